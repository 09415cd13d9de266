"""What kernels ask of LLVM."""

import pytest
from llvmlite import binding

from hydroservo.engine.machine_code import with_reciprocals, with_widest_vectors

DOUBLED = """
define void @doubled(ptr noalias %a, i64 %n) {
start:
  br label %loop
loop:
  %i = phi i64 [ 0, %start ], [ %next, %loop ]
  %place = getelementptr double, ptr %a, i64 %i
  %x = load double, ptr %place
  %y = fadd double %x, %x
  store double %y, ptr %place
  %next = add i64 %i, 1
  %more = icmp ult i64 %next, 1024
  br i1 %more, label %loop, label %end
end:
  ret void
}
"""


def assembly(text: str, processor: str) -> str:
    """The assembly of a module, vectorised for a processor."""
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    machine = binding.Target.from_triple("x86_64-unknown-linux-gnu").create_target_machine(processor, opt=3)
    module = binding.parse_assembly(text)
    options = binding.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = True
    builder = binding.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return str(machine.emit_assembly(module))


@pytest.mark.parametrize("processor", ["skylake-avx512", "icelake-server", "sapphirerapids"])
def test_vectors_are_wide_where_llvm_would_take_half(processor: str) -> None:
    assert "zmm" not in assembly(DOUBLED, processor)
    assert "zmm" in assembly(with_widest_vectors(DOUBLED), processor)


def test_vectors_are_no_wider_than_the_processor_has() -> None:
    assert assembly(with_widest_vectors(DOUBLED), "haswell").count("zmm") == 0


def test_what_is_rounded_to_a_whole_number_stays_a_quotient() -> None:
    divided = """
define void @divided(ptr %to, double %a, double %b) {
  %kept = fdiv double %a, %b
  %counts = fdiv double %a, %b
  %high = fadd double %counts, 0x4338000000000000
  %turns = fdiv double %b, %a
  %down = call double @llvm.floor.f64(double %turns)
  %index = fdiv double %a, %b
  %place = fptosi double %index to i64
  %sum = fadd double %kept, 0x4008000000000000
  ret void
}
"""
    changed = {line.split()[0] for line in with_reciprocals(divided).splitlines() if "arcp" in line}
    assert changed == {"%kept"}
