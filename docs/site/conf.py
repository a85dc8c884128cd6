"""How Sphinx makes the site of the pages in ``docs``; ``make site`` calls it.

Nothing here names the address of a site or of a repository: the workflow that publishes knows both, and says so in
``VBBENCH_SITE_URL`` and ``VBBENCH_REPOSITORY``. Without them the site is whole, but for the links "Edit this page".
"""

import logging
import os
import re
import sys
from pathlib import Path
from typing import Any

import vbbench

sys.path.insert(0, str(Path(__file__).parent))  # docstrings, headline and notebooks, beside this file

from notebooks import FIRST_CELL

project = "vbbench"
author = "the authors of vbbench"
copyright = "the authors of vbbench, Apache-2.0"  # noqa: A001
release = version = vbbench.__version__
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "docstrings",
    "headline",
]
exclude_patterns = ["images", "notebooks", "site", "tutorials/notebooks/index.rst"]
nitpicky = False
suppress_warnings = ["config.cache"]  # of options that are functions

# The pages are Markdown, as a code host shows them: links to files and headings are the host's, too.
myst_enable_extensions = ["colon_fence", "attrs_inline"]
myst_heading_anchors = 4
highlight_language = "none"  # what is indented is a shell's session or a file of text
pygments_style = "a11y-high-contrast-light"

# The reference, from docstrings.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_preserve_defaults = True
autoclass_content = "class"
napoleon_google_docstring = False
toc_object_entries_show_parents = "hide"
python_use_unqualified_type_names = True

# Notebooks: plain scripts in docs/notebooks, run when the site is built. One that fails stops the build.
sphinx_gallery_conf = {
    "examples_dirs": "notebooks",
    "gallery_dirs": "tutorials/notebooks",
    "filename_pattern": r"\.py$",
    "ignore_pattern": r"__init__\.py",
    "within_subsection_order": "FileNameSortKey",
    "first_notebook_cell": FIRST_CELL,
    "abort_on_example_error": True,
    "run_stale_examples": True,
    "only_warn_on_example_error": False,
    "download_all_examples": False,
    "min_reported_time": 1e9,
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
    "write_computation_times": False,
    "image_scrapers": ("matplotlib",),
    "capture_repr": ("_repr_html_", "__repr__"),
    "matplotlib_animations": False,
    "reset_modules": ("matplotlib",),
    "copyfile_regex": r".*\.css",
    "nested_sections": False,
}

logging.getLogger("numexpr").setLevel(logging.WARNING)  # which pandas imports, and which says how many threads it has

# The look: no fonts, scripts or pictures of other hosts.
html_theme = "pydata_sphinx_theme"
html_title = "vbbench"
html_baseurl = os.environ.get("VBBENCH_SITE_URL", "")
html_static_path = ["static"]
html_css_files = ["site.css"]
html_favicon = "static/mark.svg"
templates_path = ["templates"]
html_show_sourcelink = False
html_copy_source = False
html_context = {"repository": os.environ.get("VBBENCH_REPOSITORY", "").rstrip("/"), "default_mode": "auto"}
html_sidebars = {"index": []}
html_theme_options = {
    "logo": {"image_light": "static/mark.svg", "image_dark": "static/mark.svg", "text": "vbbench", "alt_text": ""},
    "navbar_align": "left",
    "navbar_center": ["navbar-nav", "boards"],
    "navbar_end": ["theme-switcher"],
    "header_links_before_dropdown": 5,
    "show_nav_level": 1,
    "navigation_depth": 2,
    "show_toc_level": 1,
    "secondary_sidebar_items": {"**": ["page-toc", "edit"], "index": []},
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_prev_next": True,
    "search_bar_text": "Search the pages",
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}

# The copy button takes the command, without its prompt and without what it printed.
copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True
copybutton_only_copy_prompt_lines = True
copybutton_exclude = ".linenos, .gp"


def lead_to_notebooks(_app: Any, page: str, text: list[str]) -> None:
    """A link to a notebook's script, which a code host shows, leads to what it says when it is run."""
    if page.startswith("tutorials/"):
        text[0] = re.sub(r"\(\.\./notebooks/(\w+)\.py\)", r"(notebooks/\1.rst)", text[0])


def setup(app: Any) -> None:
    """Connect it."""
    app.connect("source-read", lead_to_notebooks)
