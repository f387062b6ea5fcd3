"""A release: one version, one list of requirements, workflows that call the Makefile, names that go in time."""

import ast
import re
import runpy
import tomllib

import pytest
from trees import walk

import flexmb as fm

yaml = pytest.importorskip("yaml", reason="needs the requirements of the tests: pip install --group test")

ACTION = re.compile(r"uses: [\w.-]+/[\w.-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+")
CALL = re.compile(r"\bmake (?:PYTHON=\S+ )?((?:[a-z-]+ ?)+)")


@pytest.fixture(scope="module")
def project(root):
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def version(project):
    return project["project"]["version"]


@pytest.fixture(scope="module")
def recipe(root):
    return yaml.safe_load((root / ".github" / "conda" / "recipe.yaml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def workflows(root):
    """Texts of the workflows."""
    found = {path.name: path.read_text(encoding="utf-8") for path in (root / ".github" / "workflows").glob("*.yml")}
    assert set(found) == {"tests.yml", "release.yml", "site.yml"}
    return found


def steps(text):
    """Steps of all jobs of a workflow."""
    return [step for job in yaml.safe_load(text)["jobs"].values() for step in job["steps"]]


# Versions


def test_every_file_has_the_version_of_the_package(root, version, recipe):
    cited = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == recipe["context"]["version"] == version
    assert re.fullmatch(r"\d+\.\d+\.\d+", version)
    assert fm.__version__ == version


def test_changes_begin_with_the_version(root, version):
    heads = re.findall(r"^## (.*)$", (root / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    known = [re.fullmatch(r"(\d+)\.(\d+)\.(\d+) \((unreleased|20\d\d-\d\d-\d\d)\)", head) for head in heads]
    assert all(known), heads
    assert heads[0].partition(" ")[0] == version
    numbers = [tuple(map(int, head.groups()[:3])) for head in known]
    assert numbers == sorted(set(numbers), reverse=True)
    assert all(head[4] != "unreleased" for head in known[1:])


def test_wrong_results_come_first(root):
    newest = (root / "CHANGELOG.md").read_text(encoding="utf-8").split("\n## ")[1]
    assert re.findall(r"^### (.*)$", newest, re.MULTILINE)[0] == "Fixed: wrong results"


# Former names


def named_versions(tree):
    """Versions in which former names go: in `formerly`, in calls of `warn_of_former`, in `former=` of `lazy_names`."""
    for node in walk(tree):
        places = []
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(isinstance(target, ast.Name) and target.id == "formerly" for target in targets):
                places = [names.elts[2] for names in getattr(node.value, "elts", ())]
        elif isinstance(node, ast.Call):
            called = getattr(node.func, "id", getattr(node.func, "attr", ""))
            if called == "warn_of_former":
                places = node.args[3:4]
            for keyword in node.keywords:
                if called == "lazy_names" and keyword.arg == "former":
                    places += [names.elts[1] for names in keyword.value.values]
        yield from ((node.lineno, place.value) for place in places if isinstance(place, ast.Constant))


def overdue(sources, version):
    """Former names that should have gone, as "file:line: version"."""
    now = tuple(map(int, version.split(".")[:2]))
    naming = [source for source in sources if "former" in source.text]
    found = [(source.path, *named) for source in naming for named in named_versions(source.tree)]
    return found, [f"{path}:{at}: {goes}" for path, at, goes in found if tuple(map(int, goes.split("."))) <= now]


def test_no_former_name_is_overdue(package_sources, version):
    found, late = overdue(package_sources, version)
    assert not late
    assert len(found) > 15


def test_overdue_names_are_found(package_sources):
    found, late = overdue(package_sources, "0.3.0")
    assert len(late) == len(found)


def test_one_helper_warns(package_sources):
    calls = [source.path for source in package_sources if "DeprecationWarning," in source.text]
    assert calls == ["flexmb/namespace.py"]


# Requirements


def test_extras_are_for_users_and_groups_for_checkouts(root, project):
    groups = set(project["dependency-groups"])
    assert not groups & set(project["project"]["optional-dependencies"])
    makefile = (root / "Makefile").read_text(encoding="utf-8")
    assert set(re.findall(r"--group (\w+)", makefile)) <= groups


def test_the_recipe_asks_for_what_the_package_needs(project, recipe):
    asked = {
        line.partition(" ")[0].replace("-base", "") + line.partition(" ")[2] for line in recipe["requirements"]["run"]
    }
    needed = {f"python{project['project']['requires-python']}", *project["project"]["dependencies"]}
    assert {line.replace("${{ python_min }}", recipe["context"]["python_min"]) for line in asked} == needed
    script = project["project"]["scripts"]
    assert recipe["build"]["python"]["entry_points"] == [f"{name} = {place}" for name, place in script.items()]


def test_hooks_check_by_the_ruff_of_the_project(root, project):
    hooks = yaml.safe_load((root / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"]
    (rev,) = (repo["rev"] for repo in hooks if "ruff" in repo["repo"])
    (held,) = (line for line in project["dependency-groups"]["lint"] if line.startswith("ruff"))
    assert held == f"ruff=={rev.removeprefix('v').rpartition('.')[0]}.*"


def test_addresses_of_the_project_stand_in_one_file(root, project):
    home = project["project"]["urls"]["Homepage"]
    others = [*root.glob("*.md"), *root.glob("*.cff"), *root.glob("*.toml"), *(root / ".github").rglob("*.*")]
    others += (root / "docs").glob("*.md")
    naming = [path.name for path in others if path.is_file() and home in path.read_text(encoding="utf-8")]
    assert naming == ["pyproject.toml"]


# Workflows and forms


def test_workflows_call_targets_of_the_makefile(root, workflows):
    makefile = (root / "Makefile").read_text(encoding="utf-8")
    called = {
        t for text in workflows.values() for s in steps(text) for m in CALL.findall(s.get("run", "")) for t in m.split()
    }
    assert {"test", "review", "wheel", "try-wheel", "sdist", "site"} <= called
    assert all(f"\n{target}:" in makefile for target in called)


def test_actions_are_pinned(workflows):
    for name, text in workflows.items():
        assert text.count("uses: ") == len(ACTION.findall(text)) > 0, name


def test_workflows_may_do_no_more_than_they_need(workflows):
    for text in workflows.values():
        assert yaml.safe_load(text)["permissions"] == {"contents": "read"}
        assert "secrets." not in text
        assert "password" not in text


def test_tests_and_wheels_begin_with_the_oldest_python(project, workflows):
    oldest = project["project"]["requires-python"].removeprefix(">=")
    kinds = [job["strategy"]["matrix"]["python"] for job in all_jobs(workflows) if "strategy" in job]
    assert len(kinds) == 2
    assert kinds[0] == kinds[1]
    assert kinds[0][0] == oldest


def all_jobs(workflows):
    return [job for text in workflows.values() for job in yaml.safe_load(text)["jobs"].values()]


def test_forms_ask_for_what_a_report_needs(root):
    forms = [path for path in (root / ".github" / "ISSUE_TEMPLATE").glob("*.yml") if path.name != "config.yml"]
    assert len(forms) == 2
    for path in forms:
        form = yaml.safe_load(path.read_text(encoding="utf-8"))
        assert form["name"]
        assert form["description"]
        assert any(field.get("validations", {}).get("required") for field in form["body"])


# Site by version


def test_each_version_has_its_pages(root, tmp_path):
    lay = runpy.run_path(str(root / "docs" / "site_versions.py"))["lay"]
    site, pages = tmp_path / "site", tmp_path / "pages"
    site.mkdir()
    pages.mkdir()
    for version in ("dev", "0.9.0", "0.10.0", "dev"):
        (site / "index.html").write_text(version, encoding="utf-8")
        lay(site, pages, version)
    assert [(pages / name / "index.html").read_text("utf-8") for name in ("dev", "0.9.0")] == ["dev", "0.9.0"]
    listed = (pages / "index.html").read_text("utf-8")
    assert "url=0.10.0/index.html" in listed
    assert re.findall(r'href="([^/]+)/', listed) == ["0.10.0", "0.9.0", "dev"]
    with pytest.raises(SystemExit, match="is no version"):
        lay(site, pages, "../elsewhere")
