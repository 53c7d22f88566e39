"""MuJoCo's C functions, callable from compiled code.

Compiled code that calls ``mj_step`` holds the name only; loading it before the name is known kills the process. So this
module registers the name when it is imported, and every module with such code imports it at its top.
"""

import ctypes
from pathlib import Path

import llvmlite.binding
import mujoco
from numba import types


def _library() -> ctypes.CDLL:
    # the library is loaded already: the same file gives the same handle
    [file] = Path(mujoco.__file__).parent.glob("libmujoco.*")
    return ctypes.CDLL(str(file))


def _register(name: str) -> None:
    llvmlite.binding.add_symbol(name, ctypes.cast(getattr(_library(), name), ctypes.c_void_p).value)


def _stop_the_watch() -> None:
    """Take away the clock that MuJoCo reads some twenty times per step for its own statistics: a third of a step."""
    ctypes.c_void_p.in_dll(_library(), "mjcb_time").value = None


_register("mj_step")
_stop_the_watch()

mj_step = types.ExternalFunction("mj_step", types.void(types.intp, types.intp))
"""``mj_step(address of model, address of data)``."""
