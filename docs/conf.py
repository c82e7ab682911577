"""How Sphinx builds these pages: `make docs`, or `python -m sphinx -W docs docs/_build/html`."""

from __future__ import annotations

import os
import shutil
from importlib import import_module
from pathlib import Path

import geosurf

geosurf.write = import_module("geosurf.write").write  # the function, not the folder of that name

project = "geosurf"
author = "the geosurf authors"
version = release = geosurf.__version__
copyright = "the geosurf authors, MIT licence"  # noqa: A001 - the name that Sphinx reads

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
]
root_doc = "index"
exclude_patterns = ["_build", "_templates"]
templates_path = ["_templates"]

# ---- API pages: one for each public name, with all members of a class on its page
default_role = "autolink"  # single backticks in docstrings link where the name is documented
autosummary_generate = True
autosummary_ignore_module_all = False
autodoc_member_order = "groupwise"
autodoc_typehints = "none"  # the docstrings have types; signatures stay short
numpydoc_show_class_members = False
numpydoc_show_inherited_class_members = False
intersphinx_mapping: dict[str, tuple[str, None]] = {}  # pages build without a network
nitpick_ignore = [("py:obj", f"xarray.{name}") for name in ("DataArray", "Dataset")]
nitpick_ignore += [("py:obj", "pyvista.PolyData")]

# ---- pages in Markdown, and notebooks
HERE = Path(__file__).parent
for notebook in sorted(
    (HERE.parent / "notebooks").glob("*.ipynb")
):  # Sphinx reads below docs/ only
    page = HERE / "notebooks" / notebook.name
    if not page.exists() or page.read_bytes() != notebook.read_bytes():
        shutil.copyfile(notebook, page)
myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist"]
myst_heading_anchors = 4
os.environ["GEOSURF_PROGRESS"] = "off"  # its line would leave an empty box on the pages
nb_execution_mode = "cache"  # notebooks are stored without outputs; the build makes them
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_merge_streams = True

# ---- looks
html_theme = "pydata_sphinx_theme"
html_title = "geosurf"
html_show_sourcelink = False
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["geosurf.css"]
html_theme_options = {
    "header_links_before_dropdown": 8,
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": False,
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygment_light_style": "a11y-high-contrast-light",
}
html_sidebars: dict[str, list[str]] = {"index": [], "gallery/index": []}
