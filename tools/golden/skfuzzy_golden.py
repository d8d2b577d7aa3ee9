#!/usr/bin/env python3
"""Infers outputs from rule texts with scikit-fuzzy, for the tests of fingerpost-control.

    pip install scikit-fuzzy==0.5.0 numpy scipy networkx packaging
    python tools/golden/skfuzzy_golden.py crates/fingerpost-control/src/fuzzy/default.fuzzy \\
        crates/fingerpost-control/tests/golden/tipping.fuzzy > crates/fingerpost-control/tests/golden/skfuzzy.csv

A line is TEXT,OUTPUT,VALUE,INPUT...: the name of the rule text, an output, its value (empty where no rule concludes on it), and the
inputs' values in the order of the text. Each output is inferred on 201 places of its range: conditions by minimum, conclusions cut
at it, joined by maximum, defuzzified by centroid.
"""
import random
import sys
from pathlib import Path

import numpy as np
import skfuzzy as fuzz

SAMPLES = 201


def parse(text):
    variables, rules, terms = {"input": {}, "output": {}}, [], None
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0] in variables:
            terms = {}
            variables[words[0]][words[1]] = (float(words[2]), float(words[3]), terms)
        elif words[0] == "rule":
            rules.append(words[1:])
        else:
            terms[words[0]] = [float(word) for word in words[1:]]
    return variables["input"], variables["output"], rules


def member(places, corners):
    return fuzz.trimf(places, corners) if len(corners) == 3 else fuzz.trapmf(places, corners)


def clauses(words):
    clause = []
    for word in words + ["and"]:
        if word == "and":
            yield clause
            clause = []
        else:
            clause.append(word)


def infer(inputs, outputs, rules, values):
    strengths = []
    for rule in rules:
        shares = []
        for variable, _, *term in clauses(rule[1 : rule.index("then")]):
            share = member(np.array([values[variable]]), inputs[variable][2][term[-1]])[0]
            shares.append(1 - share if term[0] == "not" and len(term) > 1 else share)
        strengths.append(np.fmin.reduce(shares))
    for name, (least, most, terms) in outputs.items():
        places = np.linspace(least, most, SAMPLES)
        joined = np.zeros(SAMPLES)
        for rule, strength in zip(rules, strengths):
            for variable, _, term in clauses(rule[rule.index("then") + 1 :]):
                if variable == name:
                    joined = np.fmax(joined, np.fmin(strength, member(places, terms[term])))
        yield name, fuzz.defuzz(places, joined, "centroid") if joined.any() else None


random.seed(24)
print("text,output,value,inputs")
for path in sys.argv[1:]:
    inputs, outputs, rules = parse(Path(path).read_text())
    for _ in range(60):
        values = {name: round(random.uniform(least, most), 3) for name, (least, most, _) in inputs.items()}
        for output, value in infer(inputs, outputs, rules, values):
            value = "" if value is None else repr(float(value))
            print(",".join([Path(path).name, output, value, *(repr(value) for value in values.values())]))
