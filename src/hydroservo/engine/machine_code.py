"""Compiles kernels to machine code: our text to LLVM, LLVM to an object file.

Everything a kernel calls is inlined into one function that takes numbers and pointers only, allocates
nothing and touches no Python object, so that its object file can be kept and loaded without a compiler.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from heapq import heappop, heappush
from importlib.metadata import requires
from itertools import takewhile

from llvmlite import __version__ as llvmlite_version
from llvmlite import binding

from hydroservo.core.ops.basic import ROUNDER
from hydroservo.engine.llvm.entries import kernel_text
from hydroservo.engine.llvm.values import float_literal
from hydroservo.engine.native import CompileError, MachineCode, prepare_llvm
from hydroservo.engine.recipe import features
from hydroservo.language.terms import Type

PROVIDED = {"memcpy", "memset", "memmove"}  # what LLVM itself may call, in every C library
VECTORS = 2  # that go together: more wait less for each other, and no longer fit where instructions are kept
FUSIBLE = re.compile(r"(?<= = )(fadd|fsub|fmul)\b")
QUOTIENT = re.compile(r"(%[\w.]+) = fdiv (?=double)")
ROUNDED = re.compile(
    rf"(?:@llvm\.(?:ceil|floor|rint|trunc)\.f64\(|fptosi |fadd )double (%[\w.]+)"
    rf"(?:\)| to |, {float_literal(ROUNDER)})"
)
DEFINITION = re.compile(r"^(define .*) {$", re.MULTILINE)

VECTOR = "<8 x double>"
ESTIMATE = "@llvm.x86.avx512.rsqrt14.pd.512"
FMA = "@llvm.fma.v8f64"
CLASS = "@llvm.x86.avx512.fpclass.pd.512"
OWN_ROOTS = 0b1110  # the classes +0, -0 and +inf, whose roots are they themselves
DECLARED = {
    ESTIMATE: f"declare {VECTOR} {ESTIMATE}({VECTOR}, {VECTOR}, i8)",
    FMA: f"declare {VECTOR} {FMA}({VECTOR}, {VECTOR}, {VECTOR})",
    CLASS: f"declare <8 x i1> {CLASS}({VECTOR}, i32)",
}
ROOT = re.compile(
    rf"^  %([\w.]+) = (?:tail )?call (?:\w+ )*{VECTOR} @llvm\.sqrt\.v8f64\({VECTOR} (%[\w.]+)\)$",
    re.MULTILINE,
)
STEPS = f"""\
  %y = call {VECTOR} {ESTIMATE}({VECTOR} $x, {VECTOR} zeroinitializer, i8 -1)
  %g0 = fmul {VECTOR} $x, %y
  %h0 = fmul {VECTOR} %y, splat (double 5.0e-1)
  %m0 = fneg {VECTOR} %g0
  %e = call {VECTOR} {FMA}({VECTOR} %m0, {VECTOR} %h0, {VECTOR} splat (double 5.0e-1))
  %g1 = call {VECTOR} {FMA}({VECTOR} %g0, {VECTOR} %e, {VECTOR} %g0)
  %h1 = call {VECTOR} {FMA}({VECTOR} %h0, {VECTOR} %e, {VECTOR} %h0)
  %m1 = fneg {VECTOR} %g1
  %d = call {VECTOR} {FMA}({VECTOR} %m1, {VECTOR} %g1, {VECTOR} $x)
  %g2 = call {VECTOR} {FMA}({VECTOR} %d, {VECTOR} %h1, {VECTOR} %g1)
  %own = call <8 x i1> {CLASS}({VECTOR} $x, i32 {OWN_ROOTS})
  $root = select <8 x i1> %own, {VECTOR} $x, {VECTOR} %g2"""


def machine_code(function: Callable[..., int], arguments: Sequence[Type], strict: bool) -> MachineCode:
    """The machine code of a function of numbers and arrays that returns a whole number."""
    name = function.__name__
    return object_code(name, kernel_text(name, function, arguments), strict, alone=True)


def object_code(
    name: str, text: str, strict: bool, *, reciprocals: bool = False, alone: bool = False
) -> MachineCode:
    """The machine code of a function in the text of a module.

    It may multiply by ``reciprocals``; one that steps ``alone`` a single run has its instructions ordered.
    """
    prepare_llvm()
    machine, wide = processor(), "+avx512dq" in features()
    text = with_interleaving(with_widest_vectors(text) if wide else text, VECTORS)
    text = with_reciprocals(text) if reciprocals else text
    module = optimise(text, machine.triple, machine, strict)
    if wide and has_slow_roots() and not strict:
        module = parse_module(with_estimated_roots(str(module)))
    if alone:
        module = parse_module(schedule(str(module)))
    portable = PROVIDED.issuperset(external_functions(module))
    return MachineCode(name, machine.emit_object(module), portable=portable)


def processor() -> binding.TargetMachine:
    """This machine's processor, with all that it can."""
    made: binding.TargetMachine = binding.Target.from_default_triple().create_target_machine(
        cpu=binding.get_host_cpu_name(), features=features(), opt=3, codemodel="jitdefault", jit=True
    )
    return made


def has_slow_roots() -> bool:
    """Whether this processor takes roots of vectors slower than it multiplies and adds to the same end."""
    return not binding.get_host_cpu_name().startswith("znver")


def parse_module(text: str) -> binding.ModuleRef:
    try:
        return binding.parse_assembly(text)
    except RuntimeError as error:
        tried = next(one for one in requires("hydroservo") or () if one.startswith("llvmlite"))
        reason = " ".join(str(error).split())
        raise CompileError(
            f"llvmlite {llvmlite_version} refuses hydroservo's text ({reason}); "
            f"hydroservo is tried with {tried}"
        ) from None


def optimise(text: str, triple: str, machine: binding.TargetMachine, strict: bool) -> binding.ModuleRef:
    """The module of a text, made better by LLVM, vectors included.

    That a product and a sum may be rounded as one is said last, for LLVM keeps such out of vectors.
    """
    module = parse_module(text)
    module.triple, module.data_layout = triple, str(machine.target_data)
    options = binding.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = options.slp_vectorization = True
    builder = binding.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return module if strict else parse_module(FUSIBLE.sub(r"\1 contract", str(module)))


def external_functions(module: binding.ModuleRef) -> Iterator[str]:
    """The functions that a module calls and does not hold."""
    for function in module.functions:
        if function.is_declaration and not function.name.startswith("llvm."):
            yield function.name


def with_widest_vectors(module: str) -> str:
    """The text of a module whose functions take the widest vectors that AVX-512 has.

    For many processors LLVM prefers half the width, since programs that seldom need vectors lose more by a
    lower clock than they gain; here nearly all the work is in loops over lanes.
    """
    return DEFINITION.sub(r'\1 "prefer-vector-width"="512" {', module)


def with_reciprocals(module: str) -> str:
    """The text of a module in which a number may be multiplied by a reciprocal instead of divided.

    LLVM does so where it finds the reciprocal once for many: of numbers that stay what they are all along. A
    quotient that is rounded to a whole number stays one, for half a count may be met exactly.
    """
    rounded = set(ROUNDED.findall(module))
    return QUOTIENT.sub(lambda found: found[0] + "arcp " * (found[1] not in rounded), module)


def with_interleaving(module: str, vectors: int) -> str:
    """The text of a module that asks for so many vectors at a time in each loop that is vectorised.

    While one waits for its operations to end, the others go on. Loops name node 0 for what is asked of them.
    """
    return f'{module}!0 = !{{!"llvm.loop.interleave.count", i32 {vectors}}}\n'


def with_estimated_roots(module: str) -> str:
    """The text of a module whose roots of eight doubles at once come from estimates.

    With y = 1/sqrt(x) (1 + 2^-14), g = x y and h = y/2, which tend to sqrt(x) and 1/(2 sqrt(x))::

        e = 1/2 - g h,  g := g + g e,  h := h + h e,  sqrt(x) = g + h (x - g^2)

    It is within one unit in the last place; of numbers below 2e-308, which have fewer bits, within 1e-14.
    """
    found = ROOT.sub(root_steps, module)
    declared = [line for name, line in DECLARED.items() if name in found and line not in found]
    return "\n".join([found, *declared, ""])


def root_steps(call: re.Match[str]) -> str:
    """The steps in place of a call; names that hold a period are taken by no one else."""
    named = re.sub(r"%(\w+)", rf"%root.{call[1]}.\1", STEPS)
    return named.replace("$x", call[2]).replace("$root", f"%{call[1]}")


LONG = 60  # instructions of a block that is worth it
RATE = 1.5  # instructions a cycle that start beside the longest chain
BLOCK = re.compile(r"(?:^  .*\n)+", re.MULTILINE)
UNNAMED = re.compile(r"%(\d+)\b|^(\d+)(?=:)", re.MULTILINE)
NAME = re.compile(r"%[-$.\w]+")
INSTRUCTION = re.compile(r"  (?:%[-$.\w]+ = )?(?:tail |notail |musttail )?(\w+)")
PURE = "sqrt|fma|fabs|copysign|floor|ceil|rint|trunc|minnum|maxnum|[su](?:min|max)"
INTRINSIC = re.compile(rf"@llvm\.({PURE})\b")
TERMINATORS = {"br", "ret", "switch", "unreachable"}
CYCLES = {  # from operands to result, about those of processors since 2018
    **dict.fromkeys(("fadd", "fsub", "fmul", "fcmp"), 3.0),
    **dict.fromkeys(("sitofp", "uitofp", "fptosi", "load"), 5.0),
    **dict.fromkeys(("bitcast", "getelementptr"), 0.0),
    **{"fdiv": 13.0, "call": 4.0, "sqrt": 21.0, "fma": 4.0, "minnum": 2.0, "maxnum": 2.0, "select": 2.0},
}


def schedule(module: str) -> str:
    """The text of a module whose long blocks begin what leads to their ends by the longest way first.

    Results keep their bits: nothing but the order of instructions changes, and none that reads or writes
    memory passes a write.
    """
    named = UNNAMED.sub(lambda number: f"%n{number[1]}" if number[1] else f"n{number[2]}", module)
    return BLOCK.sub(lambda block: order_block(block[0]), named)


def order_block(block: str) -> str:
    """The lines of a block, what stands between its phis and its terminator in another order."""
    lines = block.splitlines(keepends=True)
    first = sum(1 for _ in takewhile(lambda line: operation_of(line) == "phi", lines))
    last = next((i for i, line in enumerate(lines) if operation_of(line) in TERMINATORS), len(lines))
    body = lines[first:last]
    if len(body) < LONG:
        return block
    order = start_order(dependencies(body), list(map(latency, body)))
    return "".join([*lines[:first], *(body[i] for i in order), *lines[last:]])


def operation_of(line: str) -> str:
    found = INSTRUCTION.match(line)
    return found[1] if found else ""


def latency(line: str) -> float:
    """How long an instruction's result takes."""
    intrinsic = INTRINSIC.search(line)
    return CYCLES.get(intrinsic[1] if intrinsic else operation_of(line), 1.0)


def dependencies(body: Sequence[str]) -> list[set[int]]:
    """For each instruction the earlier ones that must come before it."""
    places: dict[str, int] = {}
    needs: list[set[int]] = []
    reads: list[int] = []
    writes: list[int] = []  # the last one
    for i, line in enumerate(body):
        before = {places[name] for name in NAME.findall(line) if name in places}
        operation = operation_of(line)
        if operation == "load":
            before.update(writes)
            reads.append(i)
        elif operation == "store" or (operation == "call" and not INTRINSIC.search(line)):
            before.update(reads, writes)
            reads, writes = [], [i]
        needs.append(before)
        if " = " in line:
            places[line.split(maxsplit=1)[0]] = i
    return needs


def start_order(needs: Sequence[set[int]], durations: Sequence[float]) -> list[int]:
    """The order in which instructions start: of those that can, the one with the longest way to the end."""
    followers: list[list[int]] = [[] for _ in needs]
    for i, before in enumerate(needs):
        for earlier in before:
            followers[earlier].append(i)
    way = list(durations)
    for i in reversed(range(len(way))):
        way[i] += max((way[later] for later in followers[i]), default=0.0)
    missing, possible = list(map(len, needs)), [0.0] * len(way)
    order: list[int] = []
    waiting = [(0.0, i) for i, count in enumerate(missing) if not count]
    ready: list[tuple[float, int]] = []
    now = 0.0
    while waiting or ready:
        while waiting and (not ready or waiting[0][0] <= now):
            at, i = heappop(waiting)
            now = max(now, at)
            heappush(ready, (-way[i], i))
        _, i = heappop(ready)
        order.append(i)
        for later in followers[i]:
            missing[later] -= 1
            possible[later] = max(possible[later], now + durations[i])
            if not missing[later]:
                heappush(waiting, (possible[later], later))
        now += 1.0 / RATE if durations[i] else 0.0
    return order
