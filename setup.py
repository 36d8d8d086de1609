"""Builds the C++ kernels: one translation unit for each instruction set, with flags of its own. All else: pyproject.toml."""

import os
import platform
import sys

import numpy
from setuptools import Extension, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.errors import CCompilerError, ExecError, PlatformError

FOLDER = "src/kinestatics/_kernels"
COMMON = ["-std=c++17", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-fvisibility=hidden"]
WARNINGS = [
    "-Wall",
    "-Wextra",
    "-Wno-psabi",
    "-Wno-maybe-uninitialized",
    "-Wno-cast-function-type",
    "-Wno-missing-field-initializers",
]
X86_64 = platform.machine().lower() in ("x86_64", "amd64")
INSTRUCTION_SETS = {"baseline": []}
if X86_64:
    INSTRUCTION_SETS["avx2"] = ["-mavx2", "-mfma"]
    INSTRUCTION_SETS["avx512"] = ["-mavx2", "-mfma", "-mavx512f", "-mavx512dq", "-mavx512bw", "-mavx512vl"]
NO_COMPILER = """
kinestatics compiles its kernels and found no C++17 compiler that it can use (gcc 11 or newer, or clang 14 or newer).
Install one and run the same pip command again:
    Debian, Ubuntu     sudo apt install g++
    Fedora             sudo dnf install gcc-c++
    macOS              xcode-select --install
    Windows            install LLVM (clang-cl) or use WSL; Microsoft's own compiler lacks the vector extensions used here
"""


class BuildKernels(build_ext):
    """Compiles each instruction set with its flags, and says what to install where there is no compiler."""

    def build_extension(self, ext):
        sanitize = os.environ.get("KINESTATICS_SANITIZE")
        checks = [f"-fsanitize={sanitize}", "-fno-omit-frame-pointer", "-g", "-O1"]
        extra = checks if sanitize else ["-g0"]  # without debugging symbols: a tenth of the size
        include, objects = [numpy.get_include(), *self.include_dirs], []
        try:
            for name, flags in INSTRUCTION_SETS.items():
                source = f"{FOLDER}/isa_{name}.cpp"
                objects += self.compiler.compile(
                    [source], self.build_temp, extra_postargs=COMMON + WARNINGS + flags + extra, depends=ext.depends
                )
            ext.extra_objects = objects
            ext.include_dirs = include
            ext.extra_compile_args = COMMON + WARNINGS + extra
            ext.extra_link_args = extra + (["-pthread"] if sys.platform != "win32" else [])
            if sys.platform == "linux" and not sanitize:
                ext.extra_link_args.append("-Wl,-s")
            super().build_extension(ext)
        except (CCompilerError, ExecError, PlatformError) as error:
            raise SystemExit(f"{error}\n{NO_COMPILER}") from error


class LimitedApiWheel(bdist_wheel):
    """One wheel for CPython 3.11 and newer on each platform."""

    def get_tag(self):
        _, _, system = super().get_tag()
        return "cp311", "abi3", system


HEADERS = [f"{FOLDER}/{name}" for name in sorted(os.listdir(FOLDER)) if name.endswith((".hpp", ".cpp"))]
setup(
    ext_modules=[
        Extension(
            "kinestatics._kernels._core",
            [f"{FOLDER}/binding.cpp"],
            depends=HEADERS,
            language="c++",
            py_limited_api=True,
        )
    ],
    cmdclass={"build_ext": BuildKernels, "bdist_wheel": LimitedApiWheel},
)
