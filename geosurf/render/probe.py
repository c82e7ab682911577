"""Test in a separate process whether a graphics driver can draw.

`geosurf.render.backend` runs this file as a script: a driver that crashes ends only this process.
It uses the standard library only. It prints the name of the renderer and exits with 0, or prints
the reason to standard error and exits with 1.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from typing import Any

# names and numbers from EGL/egl.h, EGL/eglext.h and GL/gl.h
EGL_PLATFORM_DEVICE = 0x313F
EGL_OPENGL_API = 0x30A2
EGL_NONE = 0x3038
EGL_SURFACE_TYPE, EGL_PBUFFER_BIT = 0x3033, 0x0001
EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT = 0x3040, 0x0008
EGL_DEPTH_SIZE = 0x3025
EGL_WIDTH, EGL_HEIGHT = 0x3057, 0x3056
EGL_CONTEXT_MAJOR, EGL_CONTEXT_MINOR = 0x3098, 0x30FB
GL_RENDERER = 0x1F01
OSMESA_RGBA = 0x1908
GL_UNSIGNED_BYTE = 0x1401

# VTK draws with OpenGL 3.2
GL_VERSION_WANTED = (3, 2)
MAX_DEVICE = 16


def attributes(*values: int) -> ctypes.Array[ctypes.c_int]:
    """Return a list of EGL attributes, closed as EGL wants it."""
    return (ctypes.c_int * (len(values) + 1))(*values, EGL_NONE)


def call(library: ctypes.CDLL, name: str, *args: object) -> int:
    """Call a function that returns a pointer or a truth value."""
    function = library[name]
    function.restype = ctypes.c_void_p
    return function(*args) or 0


def egl_function(
    egl: ctypes.CDLL, name: str, restype: type, *argtypes: type
) -> Callable[..., Any] | None:
    """Return an EGL extension or OpenGL function, or None if the driver has none."""
    address = call(egl, "eglGetProcAddress", name.encode())
    return ctypes.CFUNCTYPE(restype, *argtypes)(address) if address else None


def egl_displays(egl: ctypes.CDLL) -> list[ctypes.c_void_p]:
    """Return one display per device that needs no screen, and the default one."""
    pointer, number = ctypes.c_void_p, ctypes.c_int

    # extensions that list devices need no screen; without them only the default display is left
    query = egl_function(egl, "eglQueryDevicesEXT", number, number, pointer, pointer)
    open_on = egl_function(egl, "eglGetPlatformDisplayEXT", pointer, number, pointer, pointer)
    displays: list[int | None] = []
    if query and open_on:
        # EGL fills both: handles of devices, and how many there are
        devices, count = (ctypes.c_void_p * MAX_DEVICE)(), ctypes.c_int(0)
        if query(MAX_DEVICE, ctypes.addressof(devices), ctypes.addressof(count)):
            found = devices[: count.value]
            displays = [open_on(EGL_PLATFORM_DEVICE, device, None) for device in found]
    displays.append(call(egl, "eglGetDisplay", ctypes.c_void_p(None)))
    return [ctypes.c_void_p(display) for display in displays if display]


def renderer_on(egl: ctypes.CDLL, display: ctypes.c_void_p) -> str:
    """Make an OpenGL context on one display; return its renderer, or ''."""
    if not egl.eglInitialize(display, None, None) or not egl.eglBindAPI(EGL_OPENGL_API):
        return ""
    wanted = attributes(
        EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_DEPTH_SIZE, 8
    )

    # a configuration with a buffer in memory and OpenGL
    config, count = ctypes.c_void_p(), ctypes.c_int(0)
    chosen = egl.eglChooseConfig(display, wanted, ctypes.byref(config), 1, ctypes.byref(count))
    if not chosen or count.value == 0:
        return ""

    # a context of the version that VTK wants, and 8 x 8 pixels to draw on
    major, minor = GL_VERSION_WANTED
    version = attributes(EGL_CONTEXT_MAJOR, major, EGL_CONTEXT_MINOR, minor)
    size = attributes(EGL_WIDTH, 8, EGL_HEIGHT, 8)
    context = call(egl, "eglCreateContext", display, config, ctypes.c_void_p(None), version)
    surface = call(egl, "eglCreatePbufferSurface", display, config, size)
    if not context or not surface:
        return ""

    # only a current context names its renderer
    canvas = ctypes.c_void_p(surface)
    if not egl.eglMakeCurrent(display, canvas, canvas, ctypes.c_void_p(context)):
        return ""
    get_string = egl_function(egl, "glGetString", ctypes.c_char_p, ctypes.c_int)
    name: bytes = get_string(GL_RENDERER) if get_string else b""
    return name.decode()


def probe_egl(library: str) -> str:
    """Return the renderer that EGL offers without a screen, or ''."""
    egl = ctypes.CDLL(library)
    names = (renderer_on(egl, display) for display in egl_displays(egl))
    return next((name for name in names if name), "")


def probe_osmesa(library: str) -> str:
    """Return 'OSMesa' if it draws into plain memory, or ''."""
    mesa = ctypes.CDLL(library)
    context = call(mesa, "OSMesaCreateContextExt", OSMESA_RGBA, 24, 0, 0, ctypes.c_void_p(None))
    image = (ctypes.c_ubyte * (8 * 8 * 4))()
    made = context and mesa.OSMesaMakeCurrent(
        ctypes.c_void_p(context), image, GL_UNSIGNED_BYTE, 8, 8
    )
    return "OSMesa" if made else ""


def probe_x(library: str) -> str:
    """Return 'X server' if one responds, or ''."""
    return "X server" if call(ctypes.CDLL(library), "XOpenDisplay", None) else ""


PROBES = {"egl": probe_egl, "osmesa": probe_osmesa, "x": probe_x}


def main(kind: str, library: str) -> int:
    """Probe one kind of backend through one library."""
    try:
        renderer = PROBES[kind](library)
    except (OSError, AttributeError) as error:
        sys.stderr.write(f"{error}\n")
        return 1
    sys.stdout.write(renderer)
    return 0 if renderer else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
