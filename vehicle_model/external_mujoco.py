"""MuJoCo's C functions, callable from compiled code.

Compiled code that calls ``mj_step`` holds the name only; loading it before the name is known kills the process. So this
module registers the name when it is imported, and every module with such code imports it at its top.
"""

import ctypes
from pathlib import Path

import llvmlite.binding
import mujoco
from numba import types


def _register(name: str) -> None:
    # the library is loaded already: the same file gives the same handle
    [file] = Path(mujoco.__file__).parent.glob("libmujoco.*")
    function = getattr(ctypes.CDLL(str(file)), name)
    llvmlite.binding.add_symbol(name, ctypes.cast(function, ctypes.c_void_p).value)


_register("mj_step")

mj_step = types.ExternalFunction("mj_step", types.void(types.intp, types.intp))
"""``mj_step(address of model, address of data)``."""
