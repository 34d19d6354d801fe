"""lamap.pyi says what the module has."""

import ast
import enum
import inspect
import pathlib

import pytest

import lamap

STUBS = ast.parse(pathlib.Path(lamap.__file__).with_name("lamap.pyi").read_text())


def own_members(thing):
    """Public names, and those special ones that the module defines itself."""
    special = {"__init__", "__eq__", "__copy__", "__deepcopy__", "__repr__", "__str__", "__getstate__", "__setstate__"}
    ours = {name for name in vars(thing) if not name.startswith("_")}
    return ours | (special & set(vars(thing)))


def stubbed(body):
    """Names in a body of the stubs, with their definitions."""
    found = {}
    for node in body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            found[node.target.id] = node
    return found


def classes():
    return {name: node for name, node in stubbed(STUBS.body).items() if isinstance(node, ast.ClassDef)}


def test_the_module_has_what_the_stubs_say():
    names = {name for name in vars(lamap) if not name.startswith("_")} | {"__version__"}
    assert names == set(stubbed(STUBS.body))


@pytest.mark.parametrize("name", [name for name in classes() if issubclass(getattr(lamap, name), lamap.LearnedMap)])
def test_classes_have_what_the_stubs_say(name):
    in_stubs = set(stubbed(classes()[name].body))
    members = own_members(getattr(lamap, name))
    if name == "LearnedMap":
        assert in_stubs - members == {"alias"}  # only its subclasses have one
        assert members - in_stubs == {"__init__"}  # which raises
    else:
        assert members - {"alias"} == in_stubs


def test_bases_are_those_of_the_stubs():
    for name, node in classes().items():
        bases = [ast.unparse(base).split(".")[-1] for base in node.bases]
        if "NamedTuple" in bases:
            assert list(getattr(lamap, name)._fields) == list(stubbed(node.body))
        else:
            of_module = [base.__name__ for base in getattr(lamap, name).__bases__]
            assert [base for base in of_module if base != "pybind11_object"] == bases


def test_states_are_those_of_the_stubs():
    assert issubclass(lamap.State, enum.IntEnum)
    values = {node.targets[0].id: ast.literal_eval(node.value) for node in classes()["State"].body}
    assert {state.name: int(state) for state in lamap.State} == values


def test_parameters_are_those_of_the_stubs():
    functions = [(lamap, node) for node in STUBS.body if isinstance(node, ast.FunctionDef) and node.name != "build"]
    for name, node in classes().items():
        if issubclass(getattr(lamap, name), lamap.LearnedMap):
            functions += [(getattr(lamap, name), method) for method in node.body if isinstance(method, ast.FunctionDef)]
    checked = 0
    for owner, node in functions:
        member = inspect.getattr_static(owner, node.name)
        if node.name.startswith("__") or isinstance(member, property):
            continue
        signature = inspect.signature(getattr(owner, node.name))
        arguments = node.args
        positional = [argument.arg for argument in arguments.args if argument.arg != "self"]
        defaults = dict(zip(reversed(positional), [ast.literal_eval(one) for one in reversed(arguments.defaults)]))
        keyword_only = [argument.arg for argument in arguments.kwonlyargs]
        defaults.update(zip(keyword_only, [ast.literal_eval(one) for one in arguments.kw_defaults]))
        assert list(signature.parameters) == positional + keyword_only, node.name
        for parameter in signature.parameters.values():
            expected = defaults.get(parameter.name, inspect.Parameter.empty)
            assert parameter.default == expected, (node.name, parameter.name)
            assert (parameter.kind == parameter.KEYWORD_ONLY) == (parameter.name in keyword_only)
        checked += 1
    assert checked >= 15


def test_every_keyword_of_build_is_in_its_docstring_and_taken(tmp_path):
    build = stubbed(STUBS.body)["build"]
    for argument in build.args.kwonlyargs:
        assert argument.arg in lamap.build.__doc__
        # It is no option of a map: the missing log, not an unknown option, is what is wrong.
        with pytest.raises(FileNotFoundError):
            lamap.build(tmp_path / "none.rawlog", **{argument.arg: None})


def test_everything_has_a_docstring():
    for name in stubbed(STUBS.body):
        thing = getattr(lamap, name)
        if callable(thing):
            assert thing.__doc__, name
    for name, member in vars(lamap.LearnedMap).items():
        if not name.startswith("_"):
            assert member.__doc__, name
