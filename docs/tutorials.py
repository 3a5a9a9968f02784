# SPDX-License-Identifier: Apache-2.0
"""A hook of mkdocs: makes a page of each notebook in examples/tutorials, with what its cells print and draw as it is stored."""
import base64
import json
import pathlib
import tempfile

from mkdocs.structure.files import File

NOTEBOOKS = pathlib.Path(__file__).parents[1] / "examples/tutorials"


def write_page(notebook, folder):
    """Writes the page of a notebook, and its pictures beside it."""
    text, pictures = [], 0
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            text.append(source)
            continue
        text.append(f"```python\n{source}\n```")
        for output in cell["outputs"]:
            if "text" in output:
                text.append("```text\n" + "".join(output["text"]).rstrip("\n") + "\n```")
            if "data" in output:
                picture = f"{notebook.stem}-{pictures}.png"
                (folder / picture).write_bytes(base64.b64decode(output["data"]["image/png"]))
                text.append(f"![What the cell draws]({picture})")
                pictures += 1
    text.insert(1, f"*This is the notebook `examples/tutorials/{notebook.name}`; tests run it.*")
    (folder / f"{notebook.stem}.md").write_text("\n\n".join(text) + "\n", encoding="utf-8")


def on_files(files, config):
    made = pathlib.Path(tempfile.mkdtemp())
    folder = made / "tutorials"
    folder.mkdir()
    for notebook in NOTEBOOKS.glob("*.ipynb"):
        write_page(notebook, folder)
    for file in sorted(folder.iterdir()):
        files.append(File(str(file.relative_to(made)), str(made), config["site_dir"], config["use_directory_urls"]))
    return files
