"""Sphinx's settings of the documentation: `make docs` builds it into live/site/, which the packages contain."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs")]

from live import __version__  # noqa: E402
from tools.reference.reference_pages import write_pages  # noqa: E402

write_pages()

project = "ChoreoGraphics Live"
author = "the founders of ChoreoGraphics Live"
release = version = __version__
language = "en"
html_title = f"ChoreoGraphics Live {__version__}"
html_theme = "furo"
html_static_path = ["site.css", "site.js"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_use_index = False
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_last_updated_fmt = None
templates_path: list[str] = []

extensions = ["film", "myst_parser", "sphinx_design", "sphinx_copybutton"]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False
suppress_warnings = ["myst.header"]
exclude_patterns = ["decisions", "films/README.md"]  # decisions are for those who read the code
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"
copybutton_prompt_text = "$ "
nitpicky = True
