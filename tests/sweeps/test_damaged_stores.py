"""Stores that a disk or another program has damaged: refused by name, or read with the same numbers.

The expected numbers are those of the undamaged store.
"""

import itertools
import json
import shutil

import numpy as np
import pytest
import xarray as xr
from sweep_models import logistic_map, results

import flexmb as fm
from flexmb.errors import FileFormatError

MANNERS = ("bit", "bit", "bit", "cut", "empty", "lost", "lost array")


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """A diagram and a sweep with a failed point each, and their datasets."""
    folder = tmp_path_factory.mktemp("stores")
    diagram, grid = diagram_in(folder / "diagram"), sweep_in(folder / "sweep")
    assert not diagram["ok"].values.all()
    assert not grid["ok"].values.all()
    return {"diagram": (folder / "diagram", diagram), "sweep": (folder / "sweep", grid)}


def diagram_in(store, **more):
    values = np.linspace(3.0, 3.9, 7)
    values[2] = 3.31  # fails
    return fm.bifurcation(logistic_map, "r", values, skip=20, keep=5, direction="up", store=store, **more)


def sweep_in(store, **more):
    return fm.sweep(results, {"a": [2, 1, 3], "b": [5.0, 6.0]}, store=store, **more)


def damaged(store, rng):
    """Damage one file of a store; the manner."""
    manner = MANNERS[rng.integers(len(MANNERS))]
    files = sorted(file for file in store.rglob("*") if file.is_file())
    file = files[rng.integers(len(files))]
    data = bytearray(file.read_bytes())
    if manner == "lost":
        file.unlink()
    elif manner == "lost array":
        arrays = sorted(one for one in store.iterdir() if one.is_dir())
        file = arrays[rng.integers(len(arrays))]
        shutil.rmtree(file)
    elif manner == "bit":
        place = rng.integers(8 * len(data))
        data[place // 8] ^= 1 << (place % 8)
        file.write_bytes(data)
    else:
        file.write_bytes(data[: rng.integers(len(data)) if manner == "cut" else 0])
    return f"{manner} of {file.relative_to(store)}"


def holds_no_wrong_number(found, whole):
    """Whether each point that is `ok` has the numbers of the undamaged store, and so have all coordinates."""
    assert set(found.variables) == set(whole.variables)
    assert all(found[name].attrs == whole[name].attrs for name in whole.variables)
    assert all(np.array_equal(found[name].values, whole[name].values) for name in whole.coords if name != "seam")
    told, ok = found.where(found["ok"]), found["ok"].values
    return told.equals(whole.where(found["ok"])) and not (ok & (found["status"].values == "")).any()


def attacked(path, whole, again, rng, folder):
    """What reading and going on with a damaged copy come to."""
    copy = shutil.copytree(path, folder / "copy")
    text, messages = damaged(copy, rng), []
    try:
        for read in (lambda: fm.sweeps.load_sweep(copy), lambda: again(copy, resume=True)):
            try:
                assert holds_no_wrong_number(read(), whole), text
            except (fm.errors.FileFormatError, fm.errors.InputError) as error:
                messages.append(str(error))
    finally:
        shutil.rmtree(copy)
    assert all(message.startswith("Store") for message in messages), text
    return len(messages)


@pytest.mark.slow
@pytest.mark.parametrize("count", [12, pytest.param(200, marks=pytest.mark.slow)])
def test_damaged_stores_give_no_wrong_number(stores, tmp_path, count):
    """Bits flipped, files cut, emptied and lost, whole arrays lost: 20 in some 100 gave numbers with ok=True before."""
    rng, refused = np.random.default_rng(count), 0
    for k in range(count):
        kind, again = [("diagram", diagram_in), ("sweep", sweep_in)][k % 2]
        refused += attacked(*stores[kind], again, rng, tmp_path) > 0
    assert refused > 0.5 * count  # others are healed: coordinates are written again, points without a status computed


def test_a_flipped_bit_in_a_number_is_refused(stores, tmp_path):
    copy = shutil.copytree(stores["diagram"][0], tmp_path / "s")
    chunk = copy / "points" / "c" / "0" / "1" / "0" / "0"
    data = bytearray(chunk.read_bytes())
    data[6] ^= 1
    chunk.write_bytes(data)
    with pytest.raises(fm.errors.FileFormatError, match="checksum"):
        fm.sweeps.load_sweep(copy)
    with pytest.raises(fm.errors.FileFormatError, match="checksum"):
        diagram_in(copy, resume=True)
    with pytest.raises(ValueError, match="checksum"):  # a codec of zarr: other readers refuse it, too
        xr.open_zarr(copy, consolidated=False).load()


@pytest.mark.parametrize("column", ["points", "verdict", "ok", "exponent"])
def test_a_lost_chunk_of_a_finished_point_is_refused_by_name(stores, tmp_path, column):
    copy = shutil.copytree(stores["diagram"][0], tmp_path / "s")
    place = copy / column / "c" / "0" / "1"
    chunk = place if place.is_file() else next(file for file in place.rglob("*") if file.is_file())
    chunk.unlink()
    for read in (lambda: fm.sweeps.load_sweep(copy), lambda: diagram_in(copy, resume=True)):
        with pytest.raises(fm.errors.FileFormatError, match=f"'{column}/c/0/1.*is lost"):
            read()


def chunk(store, array, *index):
    """File of the chunk of a point; its dimensions inside have one chunk."""
    place = store.joinpath(array, "c", *map(str, index))
    return place if place.is_file() else next((file for file in place.rglob("*") if file.is_file()), None)


def exchanged(one, other):
    """Exchange two files."""
    kept = one.read_bytes()
    one.write_bytes(other.read_bytes())
    other.write_bytes(kept)


@pytest.mark.parametrize(
    ("kind", "again"), [pytest.param("diagram", diagram_in, marks=pytest.mark.slow), ("sweep", sweep_in)]
)
def test_chunks_that_are_exchanged_between_points_are_refused(stores, tmp_path, kind, again):
    """Each variable, also of failed points: they loaded as each other's values before, with ok=True."""
    path, tried = stores[kind][0], set()
    columns = sorted(one.name for one in path.iterdir() if chunk(path, one.name, 0, 1))
    points = [(0, 1), (0, 3), (0, 2)] if kind == "diagram" else [(0, 1), (2, 0), (0, 0)]
    for column, (first, second) in itertools.product(columns, itertools.combinations(points, 2)):
        if chunk(path, column, *first) and chunk(path, column, *second):  # no results of a failed point
            copy = shutil.copytree(path, tmp_path / "s")
            exchanged(chunk(copy, column, *first), chunk(copy, column, *second))
            with pytest.raises(fm.errors.FileFormatError, match=f"'{column}/c.*values of another point|is lost"):
                fm.sweeps.load_sweep(copy)
            with pytest.raises(fm.errors.FileFormatError, match=f"'{column}/c.*values of another point|is lost"):
                again(copy, resume=True)
            shutil.rmtree(copy)
            tried.add(column)
    assert tried == set(columns)
    assert len(tried) >= 6


@pytest.mark.parametrize(
    "case", ["another variable", "a number for a text", "a status of another point", "a result of another point"]
)
def test_chunks_that_are_copied_are_refused(stores, tmp_path, case):
    copy = shutil.copytree(stores["sweep"][0], tmp_path / "s")
    if case == "another variable":
        exchanged(chunk(copy, "status", 1, 0), chunk(copy, "word", 1, 0))
    elif case == "a number for a text":  # its bytes are a number of texts, which took 22 GB
        shutil.copy(chunk(copy, "sum", 1, 0), chunk(copy, "status", 1, 0))
    elif case == "a status of another point":  # lost, then another one in its place
        chunk(copy, "status", 1, 0).unlink()
        shutil.copy(chunk(copy, "status", 1, 1), copy / "status" / "c" / "1" / "0")
    else:  # one that failed has none
        shutil.copy(chunk(copy, "sum", 0, 1), copy / "sum" / "c" / "0" / "0")
    for read in (lambda: fm.sweeps.load_sweep(copy), lambda: sweep_in(copy, resume=True)):
        with pytest.raises(fm.errors.FileFormatError, match="holds values of another point"):
            read()


@pytest.mark.parametrize("point", [(0, 0), (0, 1), (2, 1)])
def test_any_deleted_status_makes_a_point_unfinished(stores, tmp_path, point):
    path, whole = stores["sweep"]
    copy = shutil.copytree(path, tmp_path / "s")
    chunk(copy, "status", *point).unlink()
    found = fm.sweeps.load_sweep(copy)
    assert not found["ok"].values[point]
    assert holds_no_wrong_number(found, whole)
    assert sweep_in(copy, resume=True).identical(whole)


def test_a_point_without_a_status_is_not_ok(stores, tmp_path):
    copy = shutil.copytree(stores["diagram"][0], tmp_path / "s")
    (copy / "status" / "c" / "0" / "1").unlink()
    assert fm.sweeps.load_sweep(copy)["ok"].values.tolist() == [True, False, False, True, True, True, True]
    assert diagram_in(copy, resume=True).identical(stores["diagram"][1])


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("points/zarr.json", '"shape": [', '"shape": [9'),  # 28 GiB: a MemoryError before
        ("points/zarr.json", '"float64"', '"int64"'),
        ("r/zarr.json", '"1/s"', '"2/s"'),
        ("zarr.json", '"node_type": "group"', '"node_type": "array"'),  # ContainsArrayError before
        ("zarr.json", '"keep": 5', '"keep": 4'),
    ],
)
def test_changed_descriptions_are_refused(stores, tmp_path, file, old, new):
    copy = shutil.copytree(stores["diagram"][0], tmp_path / "s")
    text = json.dumps(json.loads((copy / file).read_text()))
    assert old in text
    (copy / file).write_text(text.replace(old, new))
    with pytest.raises(fm.errors.FileFormatError, match="does not agree with its checksum"):
        fm.sweeps.load_sweep(copy)


@pytest.mark.parametrize("kind", [pytest.param("diagram", marks=pytest.mark.slow), "sweep"])
def test_descriptions_and_coordinates_that_are_exchanged_are_refused_or_change_nothing(stores, tmp_path, kind):
    folder, before = stores[kind]
    arrays = sorted(one.name for one in folder.iterdir() if one.is_dir())
    chunks = {name: sorted(one for one in (folder / name / "c").rglob("*") if one.is_file()) for name in arrays}
    pairs = [(f"{a}/zarr.json", f"{b}/zarr.json") for a, b in itertools.pairwise([*arrays, arrays[0]])]
    whole = [chunks[name][0].relative_to(folder) for name in arrays if len(chunks[name]) == 1]
    pairs += itertools.pairwise([*whole, *whole[:1]])
    refused = []
    for number, (source, target) in enumerate(pairs):
        store = tmp_path / str(number)
        shutil.copytree(folder, store)
        shutil.copyfile(folder / source, store / target)
        try:
            found = fm.sweeps.load_sweep(store)
        except FileFormatError as error:
            refused.append(str(error))
        else:
            xr.testing.assert_identical(found, before)
    assert len(refused) >= 0.9 * len(pairs)
    assert all(text.startswith("Store") for text in refused)
