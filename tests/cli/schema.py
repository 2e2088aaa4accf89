# SPDX-License-Identifier: GPL-3.0-or-later
"""As much of JSON Schema as formats/schema uses; an unknown keyword is an error, so that nothing goes unchecked."""
import json
import re

TYPES = {'object': dict, 'array': list, 'string': str, 'boolean': bool, 'null': type(None)}
SILENT = {'$schema', '$id', '$defs', 'title', 'description'}


def is_type(value, name):
    if name == 'number':
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    if name == 'integer':
        return isinstance(value, int) and not isinstance(value, bool)
    return isinstance(value, TYPES[name])


def problems(value, schema, root=None, at=''):
    """What is wrong with `value`, as a list of lines; empty: nothing."""
    root = root or schema
    out = []
    for keyword, rule in schema.items():
        if keyword in SILENT:
            continue
        if keyword == '$ref':
            target = root
            for part in rule.removeprefix('#/').split('/'):
                target = target[part]
            out += problems(value, target, root, at)
        elif keyword == 'type':
            if not any(is_type(value, name) for name in ([rule] if isinstance(rule, str) else rule)):
                return out + [f'{at or "/"}: {value!r} is not {rule}']
        elif keyword == 'const':
            if value != rule:
                out.append(f'{at}: {value!r} is not {rule!r}')
        elif keyword == 'enum':
            if value not in rule:
                out.append(f'{at}: {value!r} is none of {rule}')
        elif keyword == 'pattern':
            if isinstance(value, str) and not re.search(rule, value):
                out.append(f'{at}: {value!r} does not match {rule}')
        elif keyword in ('minimum', 'exclusiveMinimum', 'maximum'):
            ok = {'minimum': lambda v: v >= rule, 'exclusiveMinimum': lambda v: v > rule, 'maximum': lambda v: v <= rule}
            if is_type(value, 'number') and not ok[keyword](value):
                out.append(f'{at}: {value} breaks {keyword} {rule}')
        elif keyword == 'required':
            out += [f'{at}: {name} is missing' for name in rule if isinstance(value, dict) and name not in value]
        elif keyword == 'properties':
            for name, each in rule.items():
                if isinstance(value, dict) and name in value:
                    out += problems(value[name], each, root, f'{at}/{name}')
        elif keyword == 'additionalProperties':
            if isinstance(value, dict) and rule is False:
                out += [f'{at}: {name} is not in the schema' for name in value if name not in schema.get('properties', {})]
        elif keyword == 'items':
            if isinstance(value, list):
                for n, each in enumerate(value):
                    out += problems(each, rule, root, f'{at}/{n}')
        elif keyword in ('minItems', 'maxItems'):
            if isinstance(value, list) and (len(value) < rule if keyword == 'minItems' else len(value) > rule):
                out.append(f'{at}: {len(value)} items break {keyword} {rule}')
        elif keyword in ('oneOf', 'anyOf'):
            fits = sum(not problems(value, each, root, at) for each in rule)
            if fits == 0 or (keyword == 'oneOf' and fits > 1):
                out.append(f'{at}: fits {fits} of {keyword}')
        else:
            raise ValueError(f'schema keyword {keyword} at {at or "/"} is not known')
    return out


def load(path):
    with open(path, encoding='utf-8') as file:
        return json.load(file)
