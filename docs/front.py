# SPDX-License-Identifier: Apache-2.0
"""A hook of mkdocs: makes the front page of README.md and a list of the notebook, which no menu has; writes each page as .md beside its
.html, and llms.txt (https://llmstxt.org), which lists them."""
import pathlib
import re
import tempfile

from mkdocs.structure.files import File

ROOT = pathlib.Path(__file__).parents[1]
PAGES = {"docs/notebook": "notebook/index.md", "examples/tutorials": "tutorials/pad_to_alarm.md"}  # of folders that README.md names
menu, texts = [], {}


def link(found):
    """A link of README.md on the site; what the site lacks is a path in the sources."""
    label, target = found.groups()
    page = PAGES.get(target, target[len("docs/"):] if target.startswith("docs/") else "")
    return f"[{label}]({page})" if page else f"`{target}`"


def front_page(readme):
    pictures = re.sub(r'<picture>.*?<img src="docs/(.*?)" alt="(.*?)">\n</picture>', r"![\2](\1)", readme, flags=re.S)
    return re.sub(r"(?<!!)\[([^\]]*)\]\(([^):]*)\)", link, pictures)


def list_of_notebook(folder):
    pages = [f"- {path.name[:10]}: [{path.read_text(encoding='utf-8').splitlines()[0][2:]}]({path.name})" for path in sorted(folder.glob("*.md"), reverse=True)]
    return "# Notebook\n\nDated pages of what was tried and measured; the manual is true today.\n\n" + "\n".join(pages) + "\n"


def on_files(files, config):
    made = pathlib.Path(tempfile.mkdtemp())
    (made / "notebook").mkdir()
    (made / "index.md").write_text(front_page((ROOT / "README.md").read_text(encoding="utf-8")), encoding="utf-8")
    (made / "notebook/index.md").write_text(list_of_notebook(ROOT / "docs/notebook"), encoding="utf-8")
    for name in ("index.md", "notebook/index.md"):
        files.append(File(name, str(made), config["site_dir"], config["use_directory_urls"]))
    return files


def on_nav(nav, **_):
    menu[:] = nav.items


def summary(markdown):
    """What a page is about: its sections, or its first sentence; without links."""
    text = re.sub(r"^```.*?^```$|<!--.*?-->", "", markdown, flags=re.M | re.S)
    paragraph = re.sub(r"^[#|!<*-].*$", "", text, flags=re.M).strip().split("\n\n")[0].replace("\n", " ")
    words = "; ".join(re.findall(r"^## (.*)$", text, re.M)) or re.match(r".*?[.:](?=\s|$)|.*", paragraph)[0].rstrip(":.")
    return re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", words)


def on_post_page(output, page, **_):
    texts[page.file.src_path] = re.sub(r"^<!-- test: .* -->\n", "", page.markdown, flags=re.M)
    return output


def listed(items):
    for item in items:
        if item.is_page:
            yield f"- [{item.title}]({item.file.src_path}): {summary(texts[item.file.src_path])}"
        else:
            yield f"\n## {item.title}\n"
            yield from listed(item.children)


def on_post_build(config):
    pages, sections = [item for item in menu if item.is_page], [item for item in menu if not item.is_page]
    lines = [f"# {config['site_name']}", "", f"> {config['site_description']}", "", *listed(pages), *listed(sections), "", "## Optional", "",
             f"- [Notebook](notebook/index.md): {summary(texts['notebook/index.md'])}"]
    for name, text in {**texts, "llms.txt": "\n".join(lines) + "\n"}.items():
        pathlib.Path(config["site_dir"], name).write_text(text, encoding="utf-8")
