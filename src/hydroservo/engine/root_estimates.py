"""Square roots in vectors of AVX-512, from estimates.

On Intel's processors the roots of a vector take as long as eleven multiplications, on AMD's as six
(docs/benchmarks.md), and nothing else may take a root or divide meanwhile; an axis whose valve meters at four
edges waits for little else. An estimate with 14 bits and two of Newton's steps are eight operations, between
which there is room for others.

Sources: Intel 64 and IA-32 Architectures Software Developer's Manual, VRSQRT14PD; Markstein, Computation of
elementary functions on the IBM RISC System/6000 processor, 1990 (the steps).
"""

import re

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


def with_estimated_roots(module: str) -> str:
    """The text of a module whose roots of eight doubles at once come from estimates.

    With y = 1/sqrt(x) (1 + 2^-14), g = x y and h = y/2, which tend to sqrt(x) and 1/(2 sqrt(x))::

        e = 1/2 - g h,  g := g + g e,  h := h + h e,  sqrt(x) = g + h (x - g^2)

    It is within one unit in the last place; of numbers below 2e-308, which have fewer bits, within 1e-14.
    """
    found = ROOT.sub(root, module)
    declared = [line for name, line in DECLARED.items() if name in found and line not in found]
    return "\n".join([found, *declared, ""])


def root(call: re.Match[str]) -> str:
    """The steps in place of a call; names that hold a period are taken by no one else."""
    named = re.sub(r"%(\w+)", rf"%root.{call[1]}.\1", STEPS)
    return named.replace("$x", call[2]).replace("$root", f"%{call[1]}")
