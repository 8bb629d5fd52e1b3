"""How Sphinx builds the site: ``make site``."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # generators

from hydrofdi import __version__

project = "hydrofdi"
author = "the authors of hydrofdi"
copyright = f"{author}, MIT license"
release = version = __version__

extensions = [
    "generators",
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
]
exclude_patterns = ["deploy", "_gallery", "_notebooks"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4
nb_execution_mode = "cache"
nb_execution_cache_path = str(Path(__file__).parent / "_notebooks")
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 300

smartquotes = False
default_role = "py:obj"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = True
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
python_use_unqualified_type_names = True

templates_path = ["_templates"]
html_static_path = ["_static"]
html_extra_path = ["../LICENSE"]

html_theme = "pydata_sphinx_theme"
html_title = "hydrofdi"
html_show_sourcelink = False
html_css_files = ["site.css"]
html_js_files = ["search.js"]
html_search_scorer = str(Path(__file__).parent / "_static" / "scorer.js")
html_favicon = "_static/logo.svg"
html_sidebars = {"index": [], "gallery": []}
html_theme_options = {
    "logo": {
        "text": "hydrofdi",
        "image_light": "_static/logo.svg",
        "image_dark": "_static/logo-dark.svg",
        "alt_text": "",
    },
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "navbar_end": ["about", "theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
