"""As much of JSON Schema as validate.schema.json uses."""

from collections.abc import Iterator

TYPES = {
    "object": dict,
    "array": list,
    "string": str,
    "integer": int,
    "number": (int, float),
    "null": type(None),
}


def faults(value: object, schema: dict, path: str = "$") -> Iterator[str]:
    """A sentence for each place that breaks the schema."""
    types = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    if not any(isinstance(value, TYPES[kind]) for kind in types):
        yield f"{path} is {value!r}, not {types}"
        return
    if "enum" in schema and value not in schema["enum"]:
        yield f"{path} is {value!r}"
    if isinstance(value, dict):
        for name in schema["properties"].keys() ^ value.keys():
            yield f"{path}.{name} is in one of schema and value only"
        for name in schema["properties"].keys() & value.keys():
            yield from faults(value[name], schema["properties"][name], f"{path}.{name}")
    if isinstance(value, list):
        for index, item in enumerate(value):
            yield from faults(item, schema["items"], f"{path}[{index}]")
