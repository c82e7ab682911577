"""What can happen to a kernel cache: one function for each kind of damage (`cache_damage`)."""

from __future__ import annotations

import os
import pickle
import random
import shutil
import socket
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from geosurf.files.atomic import MARK, sealed, unsealed

NOBODY = 65534
# a root that is bound by permissions as everybody else is: Linux, capabilities 1 and 2
BOUND = """
import ctypes
class Head(ctypes.Structure): _fields_ = [("version", ctypes.c_uint32), ("pid", ctypes.c_int)]
class Data(ctypes.Structure): _fields_ = [(n, ctypes.c_uint32) for n in ("e", "p", "i")]
head, data, libc = Head(0x20080522, 0), (Data * 2)(), ctypes.CDLL(None, use_errno=True)
libc.capget(ctypes.byref(head), data)
data[0].e &= ~0b110
assert libc.capset(ctypes.byref(head), data) == 0
"""


@dataclass
class Scene:
    """A cache to be damaged, and what is expected of the runs with it."""

    cache: Path
    marker: Path  # made by planted code
    chance: random.Random
    env: dict[str, str] = field(default_factory=dict)
    warns: bool = True
    heals: bool = True  # a second run, without the circumstances of the first, warns of nothing
    keeps: bool = True  # and finds kernels that the first one has kept
    at_once: int = 1
    killed: bool = False

    @property
    def kernel(self) -> Path:
        """The file of a kernel that the run needs."""
        (found,) = self.cache.glob("mesh.weld-*.nbc")
        return found

    @property
    def other(self) -> Path:
        """The file of another one."""
        (found,) = self.cache.glob("predicates.scale_of-*.nbc")
        return found

    def seal(self, payload: bytes) -> None:
        """A file with a right checksum: as geosurf itself would have written it."""
        self.kernel.write_bytes(sealed(self.kernel.name, payload))

    def plant(self) -> None:
        """Code that leaves a mark when it is unpickled, with a right checksum."""
        self.seal(pickle.dumps(Planted(str(self.marker))))

    def first(self, code: str) -> None:
        """Code that the run begins with."""
        self.env["DAMAGE_FIRST"] = code

    def lasting(self) -> None:
        """The circumstances stay as they are."""
        self.heals = False


class Planted:
    """Makes a folder when it is unpickled."""

    def __init__(self, marker: str) -> None:
        self.marker = marker

    def __reduce__(self):
        return os.mkdir, (self.marker,)


DAMAGES: list[Callable[[Scene], str | None]] = []


def damage(function):
    DAMAGES.append(function)
    return function


# ---- bytes -------------------------------------------------------------------------------


@damage
def empty(scene):
    """An empty file"""
    scene.kernel.write_bytes(b"")


@damage
def cut(scene):
    """A file cut somewhere"""
    data = scene.kernel.read_bytes()
    scene.kernel.write_bytes(data[: scene.chance.randrange(1, len(data))])


@damage
def last_byte(scene):
    """A file without its last byte"""
    scene.kernel.write_bytes(scene.kernel.read_bytes()[:-1])


@damage
def one_more(scene):
    """A file with a byte more"""
    scene.kernel.write_bytes(scene.kernel.read_bytes() + b"\0")


@damage
def one_bit(scene):
    """One bit turned over"""
    data = bytearray(scene.kernel.read_bytes())
    data[scene.chance.randrange(len(data))] ^= 1 << scene.chance.randrange(8)
    scene.kernel.write_bytes(data)


@damage
def many_bits(scene):
    """A bit of every 500 bytes turned over"""
    data = scene.kernel.read_bytes()
    scene.kernel.write_bytes(bytes(b ^ (k % 500 == 7) for k, b in enumerate(data)))


@damage
def zeros(scene):
    """A file of zeros, as after a power cut"""
    scene.kernel.write_bytes(bytes(scene.kernel.stat().st_size))


@damage
def noise(scene):
    """A file of noise"""
    scene.kernel.write_bytes(scene.chance.randbytes(5000))


@damage
def head_only(scene):
    """A head without a body"""
    scene.kernel.write_bytes(scene.kernel.read_bytes()[: len(MARK) + 65])


@damage
def swapped(scene):
    """Two kernels under each other's name"""
    one, two = scene.kernel.read_bytes(), scene.other.read_bytes()
    scene.kernel.write_bytes(two)
    scene.other.write_bytes(one)


@damage
def other_format(scene):
    """A file of another version of the format"""
    scene.kernel.write_bytes(scene.kernel.read_bytes().replace(MARK, b"geosurf keeps 0\n", 1))


# ---- contents that are not what a kernel is ----------------------------------------------


@damage
def other_python(scene):
    """A pickle of a protocol that this Python does not know"""
    scene.seal(b"\x80\x63" + pickle.dumps(("kernel",))[2:])


@damage
def no_kernel(scene):
    """A sound pickle that is no kernel"""
    scene.seal(pickle.dumps((1, "two", [3])))


@damage
def no_module(scene):
    """A pickle that names a module which is not installed"""
    scene.seal(b"cnumba_of_yesterday\nKernel\n.")


@damage
def moved_kernel(scene):
    """A kernel of the same content whose file was in another folder: no damage"""
    scene.seal(b"cgeosurf.kernels.elsewhere.mesh\nKernel\n.")
    scene.warns = False


@damage
def half_a_pickle(scene):
    """Half a pickle with a right checksum"""
    payload = unsealed(scene.kernel.name, scene.kernel.read_bytes())
    scene.seal(payload[: len(payload) // 2])


@damage
def foreign_cpu(scene):
    """A cache that another CPU has filled"""
    scene.env["NUMBA_CPU_NAME"] = "generic"
    scene.env["NUMBA_CPU_FEATURES"] = ""
    scene.warns = False


@damage
def other_options(scene):
    """A cache of kernels without checks of indices, where these are asked for"""
    scene.env["NUMBA_BOUNDSCHECK"] = "1"
    scene.warns = False


# ---- owners and permissions --------------------------------------------------------------


@damage
def file_of_another(scene):
    """Code planted in a file of another user"""
    scene.plant()
    if os.geteuid():
        return "needs root"
    return os.chown(scene.kernel, NOBODY, NOBODY)


@damage
def file_for_all(scene):
    """Code planted in a file that all can write"""
    scene.plant()
    scene.kernel.chmod(0o666)


@damage
def folder_for_all(scene):
    """Code planted in a folder that all can write"""
    scene.plant()
    scene.cache.chmod(0o777)
    scene.lasting()


@damage
def folder_for_a_group(scene):
    """Code planted in a folder that a group can write"""
    scene.plant()
    scene.cache.chmod(0o770)
    scene.lasting()


@damage
def sticky_folder(scene):
    """Code planted in a folder like /tmp"""
    scene.plant()
    scene.cache.chmod(0o1777)
    scene.lasting()


@damage
def folder_of_another(scene):
    """Code planted in a folder of another user"""
    scene.plant()
    scene.lasting()
    if os.geteuid():
        return "needs root"
    return os.chown(scene.cache, NOBODY, NOBODY)


@damage
def root_for_all(scene):
    """Code planted where all can write the folder above"""
    scene.plant()
    home = scene.cache.parent / "xdg"
    (home / "geosurf").mkdir(parents=True)
    scene.cache.rename(home / "geosurf" / "kernels")
    (home / "geosurf").chmod(0o777)
    scene.cache = Path()
    scene.env |= {"GEOSURF_CACHE_DIR": "", "XDG_CACHE_HOME": str(home)}
    scene.lasting()


@damage
def relative_xdg(scene):
    """Code planted in a folder cache/ where one stands, and XDG_CACHE_HOME=cache"""
    scene.plant()
    here = scene.cache.parent
    (here / "rel" / "geosurf").mkdir(parents=True)
    scene.cache.rename(here / "rel" / "geosurf" / "kernels")
    scene.cache = Path()
    scene.env |= {"GEOSURF_CACHE_DIR": "", "XDG_CACHE_HOME": "rel", "HOME": str(here / "home")}
    scene.first(f"os.chdir({str(here)!r})")
    scene.warns = False
    scene.lasting()


@damage
def unreadable(scene):
    """A file that nobody may read"""
    scene.kernel.chmod(0)
    scene.first(BOUND)


@damage
def read_only(scene):
    """An empty folder that cannot be written"""
    for path in scene.cache.iterdir():
        path.unlink()
    scene.cache.chmod(0o500)
    scene.first(BOUND)
    scene.lasting()


@damage
def read_only_full(scene):
    """A full folder that cannot be written"""
    scene.cache.chmod(0o500)
    scene.first(BOUND)
    scene.warns = False


@damage
def closed_folder(scene):
    """A folder that cannot be entered"""
    scene.cache.chmod(0)
    scene.first(BOUND)
    scene.lasting()


# ---- things that are no files ------------------------------------------------------------


def _elsewhere(scene) -> Path:
    """The planted kernel, moved away."""
    scene.plant()
    target = scene.cache.parent / "elsewhere"
    scene.kernel.rename(target)
    return target


@damage
def link(scene):
    """A link to planted code in place of a file"""
    place = scene.kernel
    place.symlink_to(_elsewhere(scene))


@damage
def dangling(scene):
    """A link to nothing in place of a file"""
    place = scene.kernel
    place.unlink()
    place.symlink_to(scene.cache / "nothing")


@damage
def pipe(scene):
    """A pipe without a writer in place of a file"""
    place = scene.kernel
    place.unlink()
    os.mkfifo(place, 0o600)


@damage
def unix_socket(scene):
    """A socket in place of a file"""
    place = scene.kernel
    place.unlink()
    here = Path.cwd()
    os.chdir(place.parent)  # the path of a socket is short
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind("socket")
        Path("socket").chmod(0o600)
        Path("socket").rename(place.name)
    finally:
        os.chdir(here)


@damage
def folder_as_file(scene):
    """A folder in place of a file"""
    place = scene.kernel
    place.unlink()
    place.mkdir()
    (place / "inside").write_text("x")
    scene.lasting()


@damage
def huge(scene):
    """A file of 64 GB"""
    with scene.kernel.open("r+b") as file:
        file.truncate(64 * 2**30)


@damage
def file_as_folder(scene):
    """A file in place of the cache"""
    shutil.rmtree(scene.cache)
    scene.cache.write_text("x")
    scene.lasting()


@damage
def loop_of_links(scene):
    """A cache folder that is a link to itself"""
    shutil.rmtree(scene.cache)
    scene.cache.symlink_to(scene.cache)
    scene.lasting()


@damage
def long_name(scene):
    """A cache folder whose name is too long"""
    scene.cache = scene.cache.parent / ("x" * 300)
    scene.lasting()


# ---- circumstances -----------------------------------------------------------------------


def _without_kernels(scene) -> None:
    scene.keeps = False
    for path in scene.cache.iterdir():
        path.unlink()


@damage
def no_space(scene):
    """No room: files of at most 1000 bytes"""
    _without_kernels(scene)
    scene.first("import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))")


@damage
def little_space(scene):
    """Room for the one kernel, not for the other"""
    _without_kernels(scene)
    scene.first("import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (55000, 55000))")


FAILING = """
import errno
def failing(*words, **named):
    raise OSError(errno.{}, os.strerror(errno.{}))
os.{} = failing
"""


@damage
def quota(scene):
    """A quota that shows when data are forced to the disk"""
    _without_kernels(scene)
    scene.first(FAILING.format("EDQUOT", "EDQUOT", "fsync"))


@damage
def disk_error(scene):
    """A disk that cannot read"""
    scene.env["DAMAGE_THEN"] = FAILING.format("EIO", "EIO", "fdopen")


@damage
def no_home(scene):
    """Neither a cache nor a home"""
    scene.env |= {"GEOSURF_CACHE_DIR": "", "HOME": "nowhere"}
    scene.lasting()


@damage
def deleted(scene):
    """A cache deleted in the middle of a run"""
    scene.env["DAMAGE_BETWEEN"] = f"import shutil; shutil.rmtree({str(scene.cache)!r})"
    scene.warns = False
    scene.lasting()


@damage
def deleted_and_replaced(scene):
    """A cache that becomes a file in the middle of a run"""
    cache = str(scene.cache)
    scene.env["DAMAGE_BETWEEN"] = (
        f"import shutil; shutil.rmtree({cache!r}, ignore_errors=True); open({cache!r}, 'w').close()"
    )
    scene.lasting()


@damage
def two_at_once(scene):
    """Three processes that fill one empty cache"""
    _without_kernels(scene)
    scene.warns = False
    scene.at_once = 3


@damage
def killed_before_the_move(scene):
    """A process killed when it has written, before the file is in place"""
    _without_kernels(scene)
    scene.first("import signal; os.fsync = lambda handle: os.kill(os.getpid(), signal.SIGKILL)")
    scene.killed = True


@damage
def litter(scene):
    """Foreign files and leftovers beside the kernels"""
    for number in range(50):
        (scene.cache / f".geosurf-{number:016x}.part").write_bytes(scene.chance.randbytes(99))
        (scene.cache / f"mesh.weld-{number}.nbi").write_bytes(
            pickle.dumps(Planted(str(scene.marker)))
        )
    scene.warns = False
