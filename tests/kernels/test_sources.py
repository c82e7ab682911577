"""Where the sources of kernels lie."""

import pytest

from geosurf.kernels.compile.sources import ROOT, file_of, kernel_files, module_of

pytestmark = pytest.mark.long  # of the compile machinery: an edit of kernels, not of the model


def test_no_two_kernel_files_have_one_name() -> None:
    """Compiled kernels are cached and frozen under the names of file and function."""
    names = [path.stem for path in kernel_files(ROOT)]
    assert len(names) == len(set(names)) > 30


def test_modules_and_files_name_each_other() -> None:
    assert all(file_of(module_of(path)) == path for path in kernel_files(ROOT))


def test_the_machinery_holds_no_kernels() -> None:
    assert not [path for path in kernel_files(ROOT) if path.parent.name == "compile"]
