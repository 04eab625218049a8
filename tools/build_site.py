"""The documents as a site: `./run docs`, or python tools/build_site.py [FOLDER].

The documents are written for GitHub and read as they are. They are copied into a folder of sources, with the
links of README.md, which is the first page, made those of the site; pages of the reference are made
from the package, a page of each command from its help, and one of the notebook. Sphinx then builds
it, and a warning is an error: a link that leads nowhere, a name that is not there.
"""

from __future__ import annotations

import contextlib
import importlib
import inspect
import io
import json
import re
import shutil
import sys
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CONF = ROOT / "docs" / "site"

#: Public modules beside `halfphysics` itself: title, and what is said above their names.
MODULES = {
    "halfphysics.metrics": "Measures",
    "halfphysics.scenarios": "Scenarios",
    "halfphysics.support": "Support",
    "halfphysics.baselines": "Baselines",
    "halfphysics.labels": "Labels",
    "halfphysics.sweep": "Sweeps",
    "halfphysics.actors": "Actors",
    "halfphysics.envs": "Environments",
    "halfphysics.formats": "Formats",
    "halfphysics.writers": "Writers",
    "halfphysics.render.film": "Films",
    "halfphysics.viewer.page": "Pages",
    "halfphysics.viewer.stage": "Stages",
    "halfphysics.errors": "Errors",
}
#: Names of `halfphysics` by what they are for; all others come last.
TOPICS = {
    "Motions and bodies": ["Motion", "Pose", "Body", "JOINT_NAMES", "clips", "load_sequence"],
    "Scenes": ["Scene", "Plane", "Box", "Sphere", "Capsule", "Cylinder", "Mesh"],
    "Simulation": ["simulate", "simulate_many", "Simulator", "Settings", "Sequence"],
    "MuJoCo worlds": ["attach", "bind", "step_worlds"],
    "Live sessions": ["serve", "connect"],
    "Other programs": ["compile_world"],
    "Results": ["Result", "export", "view"],
    "Repair and adaptation": ["fix", "adapt", "judge"],
    "Errors": ["HalfPhysicsError", "HalfPhysicsWarning"],
}
#: Classes that users get and do not make: module, names.
GIVEN = {
    "halfphysics.results.result": ["PersonResult", "ObjectTrack"],
    "halfphysics.results.contacts": ["Contacts"],
    "halfphysics.results.inside": ["Inside"],
    "halfphysics.simulation.frame": ["Frame"],
    "halfphysics.mujoco.attach": ["Human"],
    "halfphysics.mujoco.control": ["Control"],
    "halfphysics.mujoco.contact_data": ["PersonContacts", "PersonContact"],
    "halfphysics.repair.repair": ["Repair"],
    "halfphysics.viewer.view": ["Viewer"],
}
#: Contents of the site: heading, pages. Documents that are not here come last.
CONTENTS = {
    "Start": ["install", "tutorials/index", "first-steps", "scenarios", "gallery", "limits"],
    "How to": [
        *("viewer", "browser", "live", "protocols", "pictures", "python", "mujoco", "actors"),
        *("envs", "c-api", "fix", "holds", "labels", "sweeps"),
    ],
    "Look up": [
        *("reference/index", "reference/commands", "formats", "scene-files", "result-files"),
        "metrics",
    ],
    "Understand": ["physics", "support", "soft", "evidence", "benchmarks", "design"],
    "Project": ["contributing", "changelog", "citing"],
}
#: Files of the root that are pages, and those that can be downloaded.
PAGES = {"CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
FILES = ("LICENSE", "NOTICE", "CITATION.cff")


def main(arguments: list[str]) -> int:
    """Build; returns Sphinx's exit code."""
    from sphinx.cmd.build import main as sphinx

    out = Path(arguments[0]) if arguments else ROOT / "out" / "site"
    source = out.with_name(f"{out.name}-source")
    shutil.rmtree(source, ignore_errors=True)
    stage(source)
    code = sphinx(
        ["-W", "--keep-going", "-q", "-b", "html", "-c", str(CONF), str(source), str(out)]
    )
    if code:
        return code
    missing = sorted(public_names() - inventory(out / "objects.inv"))
    if missing:
        print(f"the reference lacks {', '.join(missing)}", file=sys.stderr)
        return 1
    print(f"site: {out / 'index.html'}")
    return 0


def public_names() -> set[str]:
    """The names that users import, `halfphysics.Motion` and the like; modules among them."""
    package = importlib.import_module("halfphysics")
    found = {f"halfphysics.{n}" for n in package.__all__ if not n.startswith("__")}
    for name in MODULES:
        module = importlib.import_module(name)
        found |= {name, *(f"{name}.{n}" for n in _own(module))}
    return found


def inventory(path: Path) -> set[str]:
    """The Python names of an inventory of Sphinx: what other sites can link to."""
    head, body = path.read_bytes().split(b"zlib.\n", 1)
    assert head.startswith(b"# Sphinx inventory version 2"), path
    lines = zlib.decompress(body).decode("utf-8").splitlines()
    return {line.split(" ", 1)[0] for line in lines if " py:" in line}


def stage(target: Path) -> None:
    """Write the sources of the site into a folder."""
    docs = ROOT / "docs"
    shutil.copytree(docs, target, ignore=shutil.ignore_patterns("site", "__pycache__"))
    for name in FILES:
        shutil.copyfile(ROOT / name, target / name)
    home = (ROOT / "README.md").read_text(encoding="utf-8")
    (target / "index.md").write_text(_of_the_site(home) + _toctrees(), encoding="utf-8")
    for name, page in PAGES.items():
        text = (ROOT / name).read_text(encoding="utf-8")
        (target / page).write_text(_of_the_site(text), encoding="utf-8")
    tutorials = target / "tutorials" / "index.md"
    below = "\n".join(p.stem for p in sorted(tutorials.parent.glob("*.md")) if p != tutorials)
    tutorials.write_text(f"{tutorials.read_text('utf-8')}\n{_toctree('', below)}", encoding="utf-8")
    notebook = ROOT / "examples" / "first_steps.ipynb"
    (target / "first-steps.md").write_text(_page_of_notebook(notebook), encoding="utf-8")
    (target / "reference").mkdir()
    for name, text in reference().items():
        (target / "reference" / name).write_text(text, encoding="utf-8")


def _of_the_site(text: str) -> str:
    """Links from the root of the repository as links of the site."""
    text = re.sub(r"\]\(docs/", "](", text)
    for name, page in PAGES.items():
        text = text.replace(f"]({name})", f"]({page})")
    return text


def _toctrees() -> str:
    listed = {page for pages in CONTENTS.values() for page in pages}
    others = sorted({path.stem for path in (ROOT / "docs").glob("*.md")} - listed)
    contents = CONTENTS | ({"More": others} if others else {})
    return "\n" + "\n".join(_toctree(head, "\n".join(p)) for head, p in contents.items())


def _toctree(caption: str, pages: str) -> str:
    said = f":caption: {caption}\n" if caption else ""
    return f"```{{toctree}}\n:hidden:\n{said}\n{pages}\n```\n"


def _page_of_notebook(path: Path) -> str:
    """The cells of a notebook as a page: text, and code to copy."""
    parts = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
    note = f"This page is the notebook `{path.relative_to(ROOT).as_posix()}`, without its outputs."
    return "\n\n".join([parts[0], note, *parts[1:]]) + "\n"


def reference() -> dict[str, str]:
    """Page -> its text in reStructuredText."""
    pages = {"halfphysics.rst": _names_of_the_package(), "given.rst": _given()}
    for name, title in MODULES.items():
        pages[f"{name}.rst"] = _module(name, title)
    listed = "\n".join(f"   {page.removesuffix('.rst')}" for page in pages)
    pages["index.rst"] = (
        f"{_title('Reference', '=')}"
        "Every public name, from its docstring. Metres, kilograms, seconds; the world is z-up; "
        "quaternions are w, x, y, z; rotations axis-angle [rad]; arrays are float64 where nothing "
        f"else is said.\n\n.. toctree::\n   :maxdepth: 2\n\n{listed}\n"
    )
    pages["commands.rst"] = _commands()
    return pages


def _title(text: str, sign: str) -> str:
    return f"{text}\n{sign * len(text)}\n\n"


def _names_of_the_package() -> str:
    package = importlib.import_module("halfphysics")
    parts = [_title("halfphysics", "=")]
    for topic, names in _topics(package.__all__).items():
        parts.append(_title(topic, "-"))
        parts += [_entry("halfphysics", name, getattr(package, name)) for name in names]
    return "\n".join(parts)


def _topics(names: list[str]) -> dict[str, list[str]]:
    """`TOPICS`, and the names that are in none of them and no modules."""
    listed = {name for some in TOPICS.values() for name in some}
    modules = {name.rpartition(".")[2] for name in MODULES}
    others = [n for n in names if n not in listed | modules and not n.startswith("__")]
    return TOPICS | ({"More": others} if others else {})


def _given() -> str:
    """Classes that functions return."""
    parts = [_title("What is returned", "=")]
    for module, names in GIVEN.items():
        found = importlib.import_module(module)
        parts += [_entry(module, name, getattr(found, name)) for name in names]
    return "\n".join(parts)


def _module(name: str, title: str) -> str:
    module = importlib.import_module(name)
    parts = [_title(f"{title}: {name}", "="), f".. automodule:: {name}\n   :no-members:\n"]
    parts += [_entry(name, n, getattr(module, n)) for n in _own(module)]
    return "\n".join(parts)


def public(module: object) -> list[str]:
    """`__all__`, else what the module itself defines without an underscore."""
    listed = getattr(module, "__all__", None)
    if listed is not None:
        return list(listed)
    name = getattr(module, "__name__", "")
    return [
        key
        for key, value in vars(module).items()
        if not key.startswith("_")
        and (inspect.isclass(value) or inspect.isfunction(value))
        and value.__module__ == name
    ]


def _own(module: object) -> list[str]:
    """Public names of a module that are not the package's, too: those have their entry there."""
    package = importlib.import_module("halfphysics")
    return [n for n in public(module) if getattr(module, n) is not getattr(package, n, None)]


def _entry(module: str, name: str, value: object) -> str:
    place = f"{module}.{name}"
    if inspect.isclass(value):
        extra = "" if issubclass(value, BaseException) else "   :members:\n"
        return f".. autoclass:: {place}\n{extra}"
    if inspect.isfunction(value):
        return f".. autofunction:: {place}\n"
    if inspect.ismodule(value):
        return f"See :doc:`{place}`.\n"
    listed = ", ".join(f"``{key}``" for key in value) if isinstance(value, tuple | dict) else ""
    return f".. py:data:: {name}\n   :module: {module}\n\n   {listed}\n"


def _commands() -> str:
    """A section of each command: what --help prints."""
    from halfphysics.cli import COMMANDS, main

    parts = [_title("The command line", "="), "What ``halfphysics COMMAND --help`` prints.\n"]
    for name, about in COMMANDS.items():
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            main([name, "--help"])
        text = re.sub(r"\x1b\[[0-9;]*m", "", said.getvalue())
        body = "\n".join(f"   {line}".rstrip() for line in text.splitlines())
        about = re.sub(r"(--\w+)", r"``\1``", f"{about[:1].upper()}{about[1:]}")
        parts += [
            _title(name, "-"),
            f"{about}.\n",
            f".. code-block:: text\n\n{body}\n",
        ]
    return "\n".join(parts)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
