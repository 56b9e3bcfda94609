"""Interface to numba: kernels with explicit signatures, loaded or compiled at first need.

A lazy function of numba's silently compiles again for a read-only, strided or float64 array, which costs about forty
frames during a show. Here every kernel states its types: it is compiled for them only, and a wrong array raises
TypeError. A kernel is compiled once for a machine: `kernel_store` keeps it under a name that follows its sources.

The code is compiled for this machine's processor (*native*), or it was shipped for a level of processors
(`choreographics-live-kernels`). All processes of a show use one set, `KERNEL_SET`.
"""

import gc
import hashlib
import json
import os
import struct
import sys
import sysconfig
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, TypeVar

import llvmlite.binding as llvm
import numpy as np

from live.base.disk.kernel_store import KernelStore, content_name, processor_levels, shipped_folder, writable_root
from live.base.system.process_control import defer_signals

Function = TypeVar("Function", bound=Callable[..., Any])

_TARGET: Final = "LIVE_KERNEL_TARGET"
"""Environment variable: the processor for which kernels are compiled, `native` or a level; inherited in a show."""


def host_processor() -> tuple[str, str, dict[str, bool]]:
    """Return name, features as text and features of this machine's processor."""
    try:
        features = dict(llvm.get_host_cpu_features())
    except RuntimeError:  # LLVM knows none for this processor
        features = {}
    text = ",".join(("+" if on else "-") + name for name, on in sorted(features.items()))
    return llvm.get_host_cpu_name(), text, features


def set_name(target: str) -> str:
    """Return the name of the kernel set for a processor level, or for `native`, this machine's processor."""
    if target == "native":
        name, features, _ = host_processor()
        target = f"{name}-{hashlib.sha256(features.encode()).hexdigest()[:8]}"
    parts = (sys.implementation.cache_tag, f"numba{version('numba')}", f"llvmlite{version('llvmlite')}")
    name = "-".join((*parts, sysconfig.get_platform().replace("-", "_"), target))
    return f"{name}-bounds" if os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0") else name


def _choose() -> tuple[str, KernelStore]:
    """Choose between native kernels, if all are compiled or none is shipped, and shipped ones."""
    own = writable_root()
    native = KernelStore((own / set_name("native"),))
    wished = os.environ.get(_TARGET) or None
    if wished == "native" or (wished is None and native.is_complete()):
        return "native", native
    for level in [wished] if wished else processor_levels(host_processor()[2]):
        shipped = shipped_folder(set_name(level))
        if shipped is not None or wished:
            return level, KernelStore((*([shipped] if shipped else ()), own / set_name(level)))
    return "native", native


KERNEL_TARGET, KERNEL_STORE = _choose()
"""The processor for which this process's kernels are compiled, and where they lie."""

KERNEL_SET: Final = KERNEL_STORE.own.name
"""Name of the kernel set of this process; journals carry it."""

os.environ[_TARGET] = KERNEL_TARGET
if KERNEL_TARGET != "native":
    os.environ["NUMBA_CPU_NAME"], os.environ["NUMBA_CPU_FEATURES"] = KERNEL_TARGET, ""

import numba  # noqa: E402 - its processor has to be set first
from numba.core import sigutils, types, typing  # noqa: E402
from numba.core.codegen import CPUCodeLibrary  # noqa: E402
from numba.core.compiler import CompileResult  # noqa: E402
from numba.core.compiler_lock import global_compiler_lock  # noqa: E402
from numba.core.environment import Environment, lookup_environment  # noqa: E402
from numba.core.funcdesc import PythonFunctionDescriptor  # noqa: E402
from numba.core.registry import CPUDispatcher  # noqa: E402
from numba.core.runtime import rtsys  # noqa: E402

JIT_DISABLED = bool(numba.config.DISABLE_JIT)
BOUNDS_CHECKED = bool(numba.config.BOUNDSCHECK)
"""Set by `NUMBA_BOUNDSCHECK=1`: a kernel that reads or writes beyond an array raises IndexError."""

_OPTIONS: Final[dict[str, Any]] = {
    "nopython": True, "nogil": True, "error_model": "numpy",
    "no_cfunc_wrapper": True,  # nothing calls kernels from C, and it takes a twelfth of the time to compile
}  # fmt: skip

kernels: "list[Kernel]" = []
"""Every kernel of the modules imported so far, in order of definition."""


class _StoreCache:
    """What numba asks for compiled code: this kernel's file in `KERNEL_STORE`."""

    def __init__(self, kernel: "Kernel") -> None:
        self._kernel = kernel

    def load_overload(self, _sig: Any, context: Any) -> None:
        """Return nothing: `Kernel.load` was called before."""
        context.refresh()

    def save_overload(self, _sig: Any, result: CompileResult) -> None:
        """Write a compiled kernel."""
        data = _to_bytes(result)
        if data is not None:
            KERNEL_STORE.write(self._kernel.file_name, data)


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A function compiled for one signature when it is first called, compiled into another kernel, or prepared."""

    def __init__(self, function: Callable[..., Any], signature: str, options: dict[str, Any]) -> None:
        super().__init__(py_func=function, targetoptions={**_OPTIONS, **options})
        self.signature = signature
        path = Path(function.__code__.co_filename).resolve()
        self.file_name = f"{content_name(path)}.{function.__qualname__}"
        self._cache = _StoreCache(self)
        self._bitcode: bytes | None = None
        kernels.append(self)

    @property
    def ready(self) -> bool:
        """Whether a call runs at once."""
        return bool(self.overloads)

    def load(self) -> bool:
        """Take the compiled code from disk, if it is there and whole; return whether the kernel is ready."""
        if self.overloads:
            return True
        # several threads may call a kernel for the first time, and Ctrl-C may come meanwhile
        with defer_signals(), global_compiler_lock:
            if self.overloads:
                return True
            data = KERNEL_STORE.read(self.file_name)
            if data is None:
                return False
            try:
                result, self._bitcode = _from_bytes(self, data)
            except Exception:  # code of a numba that was built otherwise: compile anew
                return False
            self.add_overload(result)
            self.disable_compile()
            return True

    def prepare(self) -> None:
        """Make the kernel ready: load it, or compile it unless another process is just doing so."""
        with defer_signals(), global_compiler_lock:
            if not self.load():
                self._compile()

    def _compile(self) -> None:
        """Compile the kernel; wait if another process is just doing so."""
        with KERNEL_STORE.compiling(self.file_name):
            if self.load():
                return
            collects = gc.isenabled()
            gc.disable()  # a fifth of numba's time goes into looking for garbage among objects that it still needs
            try:
                self.compile(self.signature)
            finally:
                if collects:
                    gc.enable()
        self.disable_compile()

    def _compile_for_args(self, *args: Any, **kws: Any) -> "Kernel":
        """Called by numba before the first call; what it returns is called with the same arguments."""
        self.prepare()
        return self

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Called by numba while it compiles a kernel that calls this one."""
        self.prepare()
        self._link()
        return super().get_call_template(args, kws)

    def _link(self) -> None:
        """Make a kernel loaded from disk known to the compiler, so that others can be linked against it."""
        if self._bitcode is None:
            return
        self.targetctx.refresh()
        (result,) = self.overloads.values()
        result.library._shared_module = llvm.parse_bitcode(self._bitcode)
        result.library._codegen._engine._load_defined_symbols(result.library._shared_module)
        self.targetctx.insert_user_function(result.entry_point, result.fndesc, [result.library])
        self._bitcode = None


_HEADER: Final = struct.Struct("<II")
"""Lengths of the description (JSON) and of the object code; the bitcode follows."""


def _to_bytes(result: CompileResult) -> bytes | None:
    """Return a compiled kernel as bytes; None if it holds what cannot be kept, so that it is compiled at each start."""
    (_, kind, (code, bitcode)), described, env, _, objectmode, lifted, _, reload_init, envs = result._reduce()
    try:
        description = {
            "module": described.modname, "name": described.qualname, "unique": described.unique_name,
            "symbol": described.mangled_name, "env": described.env_name, "arguments": described.args,
            "envs": [[each.globals["__name__"], each.env_name, _constants(each)] for each in (env, *envs)],
        }  # fmt: skip
    except TypeError:
        return None
    if kind != "object" or reload_init or objectmode or lifted:
        return None
    text = json.dumps(description).encode()
    return _HEADER.pack(len(text), len(code)) + text + bytes(code) + bytes(bitcode)


def _constants(env: Any) -> list[str]:
    """Return the objects that compiled code uses, which are types of array elements, by name; raise TypeError else."""
    if not all(isinstance(each, np.dtype) for each in env.consts):
        raise TypeError(f"only a dtype can be kept: {env.consts}")
    return [each.str for each in env.consts]


def _environment(module: str, name: str, constants: list[str]) -> Any:
    """Return numba's environment of a compiled function, without importing the module of one that was compiled into it.

    Code of kernels looks at no global of its module.
    """
    known = lookup_environment(name)
    if known is not None:
        return known
    made = Environment(vars(sys.modules[module]) if module in sys.modules else {"__name__": module})
    made.consts[:] = [np.dtype(each) for each in constants]
    made.env_name = name
    Environment._memo[name] = made
    return made


_libraries: Final[list[CPUCodeLibrary]] = []
"""Libraries of all kernels that were loaded, also of those whose loading failed halfway: LLVM keeps a module for good,
and asks its library for code when it next compiles."""


def _from_bytes(kernel: Kernel, data: bytes) -> tuple[CompileResult, bytes]:
    """Make a compiled kernel from what `_to_bytes` gave; return it and the bitcode for other kernels.

    numba's own way unpickles, parses the bitcode, lists its symbols and loads all that a compiler needs. That takes
    most of the time, and only the compilation of other kernels needs it (`Kernel._link`).
    """
    length, end = _HEADER.unpack_from(data)
    begin = _HEADER.size + length
    known = json.loads(data[_HEADER.size : begin])
    code, bitcode = data[begin : begin + end], data[begin + end :]
    arguments, returned = sigutils.normalize_signature(kernel.signature)
    described = PythonFunctionDescriptor(
        True, known["module"], known["name"], known["unique"], "", None, returned, None, tuple(known["arguments"]), (),
        mangler=lambda *_, **__: known["symbol"], argtypes=arguments, env_name=known["env"],
    )  # fmt: skip
    env, *envs = (_environment(*each) for each in known["envs"])
    context = kernel.targetctx
    rtsys.initialize(context)
    library: CPUCodeLibrary = context.codegen().create_library(known["name"])
    _libraries.append(library)
    library.enable_object_caching()
    library._set_compiled_object(code)
    library._finalize_final_module()
    library._codegen._engine._defined_symbols.add(described.llvm_cpython_wrapper_name)
    result = CompileResult(
        target_context=context,
        typing_context=context.typing_context,
        library=library,
        environment=env,
        entry_point=context.get_executable(library, described, env),
        fndesc=described,
        type_annotation="",
        signature=typing.signature(types.none if returned is None else returned, *arguments),
        objectmode=False,
        lifted=(),
        typing_error=None,
        call_helper=None,
        metadata=None,
        reload_init=(),
        referenced_envs=envs,
    )
    for each in envs:
        library.codegen.set_env(each.env_name, each)
    return result, bitcode


def kernel(signature: str, **options: Any) -> Callable[[Function], Function]:
    """Compile a function for one signature, e.g. ``"void(f4[:,::1], f4)"``; nogil, kept on disk, IEEE division.

    The caller owns every array; a kernel allocates nothing that outlives it and raises nothing.
    With `NUMBA_DISABLE_JIT=1` the plain Python function remains; with `NUMBA_BOUNDSCHECK=1` (`make test-bounds`) the
    compiled one checks its indices.
    """

    def define(function: Function) -> Function:
        return function if JIT_DISABLED else Kernel(function, signature, options)

    return define


def inline_kernel(function: Function) -> Function:
    """Mark a function that is inlined into each kernel that calls it; only kernels may call it.

    It has no compiled form, so it needs no signature. Inlining also keeps the known lengths of arrays that a kernel
    makes, which vectorisation depends on.
    """
    inlined: Function = numba.njit(nogil=True, error_model="numpy", inline="always")(function)
    return inlined
