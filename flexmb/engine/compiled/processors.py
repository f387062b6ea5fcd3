"""Generic processors for which compiled code is shipped."""

PORTABLE_PROCESSORS = {"x86_64": "x86-64-v3"}
"""Processor for which code is made, for each architecture; others compile for themselves."""

REQUIRED_FEATURES = {
    "x86-64-v3": (
        "avx avx2 bmi bmi2 cmov cx16 f16c fma fxsr lzcnt mmx movbe popcnt sahf sse sse2 sse3 sse4.1 sse4.2 ssse3 xsave"
    ).split()
}
"""LLVM's names of what such a processor can do."""
