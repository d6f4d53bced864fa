"""Mutation testing of Rust files: all mutants in one build, each behind a switch.

    pip install tree-sitter tree-sitter-rust
    python tests/stress/rust_mutants.py make /somewhere/copy 'src/force_law/*.rs'
    python tests/stress/rust_mutants.py run /somewhere/copy --tests lib force_law

`make` copies the commit and writes each mutant beside the code that it changes, with its number as
condition. Mutants that do not compile are taken out. `run` records which tests reach which mutants,
and runs those tests with one mutant at a time, until one fails. Changes are those of cargo-mutants:
operators of two operands and of assignments, minus and not left out, functions that return a
constant at once. Match arms and guards stay. Constants, tests and macros are left out.

`--one-in` takes a sample of the mutants, `--match` some of the tests.
"""

from __future__ import annotations

import argparse
import collections
import json
import os
import re
import resource
import signal
import subprocess
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIMIT = 5.0  # processor time of tests with a mutant over that without, behind 5 s of grace
MEMORY = 4 * 2**30  # of a test [bytes]
BINARY = {
    "+": "-*", "-": "+/", "*": "+/", "/": "%*", "%": "/+", "&": "|^", "|": "&^", "^": "|&",
    "<<": [">>"], ">>": ["<<"], "==": ["!="], "!=": ["=="], "&&": ["||"], "||": ["&&"],
    "<": ["==", ">", "<="], ">": ["==", "<", ">="], "<=": [">"], ">=": ["<"],
}  # fmt: skip
ASSIGNED = {"+=": ["-=", "*="], "-=": ["+=", "/="], "*=": ["+=", "/="], "/=": ["%=", "*="]}
RETURNED = {
    "f64": ["0.0", "1.0", "-1.0"], "bool": ["true", "false"], "usize": ["0", "1"],
    "Self": ["Default::default()"],
}  # fmt: skip
LEFT_OUT = {
    "const_item", "static_item", "macro_invocation", "macro_definition", "attribute_item",
    "type_arguments", "array_type", "where_clause", "line_comment", "block_comment",
}  # fmt: skip
SWITCH = """
/// Number of the mutant that is active, from the environment.
pub mod mutant {
    use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
    use std::sync::LazyLock;

    static ACTIVE: LazyLock<u32> =
        LazyLock::new(|| std::env::var("MUTANT").map_or(u32::MAX, |text| text.parse().unwrap()));
    static REACHED: [AtomicU8; COUNT] = [const { AtomicU8::new(0) }; COUNT];

    /// Return whether a mutant is active; without any, its file says that it was reached.
    #[inline]
    pub fn is(number: u32) -> bool {
        if *ACTIVE != u32::MAX {
            return *ACTIVE == number;
        }
        if REACHED[number as usize].swap(1, Relaxed) == 0 {
            if let Ok(path) = std::env::var("MUTANTS_REACHED") {
                use std::io::Write;
                let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
                file.unwrap().write_all(format!("{number}\\n").as_bytes()).unwrap();
            }
        }
        false
    }
}
"""


class Mutants:
    """The mutants of all files, with those that are left out."""

    def __init__(self, dropped: set[str], one_in: int) -> None:
        self.dropped, self.one_in, self.found = dropped, one_in, []

    def number(self, path: str, node: object, text: str) -> int | None:
        """Return the number of a mutant, or None where it was taken out."""
        row, column = (node.child_by_field_name("operator") or node).start_point
        name = f"{path}:{row + 1}:{column + 1}: {text}"
        if name in self.dropped or zlib.crc32(name.encode()) % self.one_in:
            return None
        self.found.append(name)
        return len(self.found) - 1


class File:
    """One file, written again with its mutants."""

    def __init__(self, path: str, source: bytes, mutants: Mutants) -> None:
        import tree_sitter
        import tree_sitter_rust

        self.path, self.source, self.mutants = path, source, mutants
        language = tree_sitter.Language(tree_sitter_rust.language())
        self.root = tree_sitter.Parser(language).parse(source).root_node

    def text(self, node: object) -> str:
        return self.source[node.start_byte : node.end_byte].decode()

    def written_whole(self) -> str:
        """Return the text of the file, with its mutants."""
        return self.written(self.root)

    def written(self, node: object, inside: bool = False) -> str:
        """Return the text of a node with the mutants in it; `inside` a function they begin."""
        kind = node.type
        if kind in LEFT_OUT or self.is_test(node) or self.is_constant(node):
            return self.text(node)
        if kind == "function_item":
            inside = True
        parts, at = [], node.start_byte
        for child in node.children:
            parts.append(self.source[at : child.start_byte].decode())
            parts.append(self.written(child, inside))
            at = child.end_byte
        parts.append(self.source[at : node.end_byte].decode())
        whole = "".join(parts)
        if not inside:
            return whole
        if kind == "function_item":
            return self.with_constants(node, whole)
        choices = [
            f"if crate::mutant::is({number}) {{ {changed} }} else "
            for text, changed in self.changes(node)
            if (number := self.mutants.number(self.path, node, text)) is not None
        ]
        if not choices:
            return whole
        close = "" if kind == "compound_assignment_expr" else ")"
        return f"{'(' if close else ''}{''.join(choices)}{{ {whole} }}{close}"

    def is_test(self, node: object) -> bool:
        before = node.prev_named_sibling
        while before is not None and before.type in ("attribute_item", "line_comment"):
            if "cfg(test)" in self.text(before) or self.text(before) == "#[test]":
                return True
            before = before.prev_named_sibling
        return False

    def is_constant(self, node: object) -> bool:
        """Return whether a node is a constant function or the length of an array."""
        before, around = node.prev_sibling, node.parent
        if node.type == "function_item":
            modifiers = (c for c in node.children if c.type == "function_modifiers")
            return any("const" in self.text(each) for each in modifiers)
        of_array = around is not None and around.type == "array_expression"
        return of_array and before is not None and before.type == ";"

    def changes(self, node: object) -> Iterator[tuple[str, str]]:
        """Yield name and text of each change of a node."""
        if node.type in ("binary_expression", "compound_assignment_expr"):
            left, operator, right = (
                self.text(node.child_by_field_name(n)) for n in ("left", "operator", "right")
            )
            if operator in ("&&", "||") and re.search(r"\blet\b", self.text(node)):
                return
            table = BINARY if node.type == "binary_expression" else ASSIGNED
            for other in table.get(operator, ()):
                target = left if table is ASSIGNED else f"({left})"
                yield f"{operator} -> {other}", f"{target} {other} ({right})"
        elif (
            node.type == "unary_expression"
            and self.text(node)[0] in "-!"
            and node.children[1].type not in ("integer_literal", "float_literal")
        ):
            yield f"{self.text(node)[0]} left out", self.text(node.children[1])

    def with_constants(self, node: object, whole: str) -> str:
        """Return a function that returns constants at once."""
        returned, body = (node.child_by_field_name(n) for n in ("return_type", "body"))
        if body is None or len(body.named_children) == 0:
            return whole
        kind = None if returned is None else self.text(returned)
        name = self.text(node.child_by_field_name("name"))
        values = ["()"] if kind is None else RETURNED.get(kind, [])
        if kind is not None and kind.startswith("Option<"):
            values = ["None"]
        early = "".join(
            f"if crate::mutant::is({number}) {{ return {value}; }} "
            for value in values
            if self.text(body).strip("{} \n") != value
            if (number := self.mutants.number(self.path, node, f"{name} returns {value}"))
            is not None
        )
        at = whole.index("{", len(self.source[node.start_byte : body.start_byte].decode()))
        return f"{whole[: at + 1]} {early}{whole[at + 1 :]}"


def make(copy: Path, patterns: list[str], one_in: int) -> None:
    """Copy the repository and put the mutants in, without those that do not compile.

    Of `one_in` mutants one is taken, by a hash of its name.
    """
    copy.mkdir(parents=True, exist_ok=True)
    archive = subprocess.run(
        ["git", "-C", ROOT, "archive", "HEAD"], capture_output=True, check=True
    )
    subprocess.run(["tar", "x", "-C", copy], input=archive.stdout, check=True)
    found = [p for each in patterns for p in copy.glob(each) if p.name != "tests.rs"]
    paths = sorted({str(p.relative_to(copy)) for p in found})
    originals = {path: (copy / path).read_bytes() for path in paths}
    # Constants that a mutant makes negative, or zero as a divisor, are errors otherwise.
    library = "#![allow(warnings, arithmetic_overflow, unconditional_panic)]\n"
    library += (copy / "src/lib.rs").read_text()
    command = ["cargo", "check", "--locked", "--lib", "--message-format=json"]
    dropped: set[str] = set()
    while True:
        mutants = Mutants(dropped, one_in)
        for path, source in originals.items():
            (copy / path).write_text(File(path, source, mutants).written_whole())
        count = SWITCH.replace("COUNT", str(max(len(mutants.found), 1)))
        (copy / "src/lib.rs").write_text(library + count)
        done = subprocess.run(command, cwd=copy, capture_output=True, text=True, check=False)
        failing = set(errors_of(done.stdout, copy, mutants.found))
        print(len(mutants.found), "mutants,", len(failing), "do not compile", flush=True)
        if not failing:
            break
        dropped |= failing
    if done.returncode:
        sys.exit(done.stderr)
    (copy / "mutants.json").write_text(json.dumps(mutants.found))
    print(len(dropped), "taken out")


def errors_of(output: str, copy: Path, names: list[str]) -> Iterator[str]:
    """Yield the mutants in which, or nearest before which, the compiler finds an error."""
    for line in output.splitlines():
        message = json.loads(line).get("message")
        if not isinstance(message, dict) or message.get("level") != "error":
            continue
        for span in message["spans"]:
            if not span["is_primary"] or not (copy / span["file_name"]).exists():
                continue
            text = (copy / span["file_name"]).read_bytes()
            before = re.findall(rb"mutant::is\((\d+)\)", text[: span["byte_start"]])
            if before:
                yield names[int(before[-1])]


def binaries(copy: Path, wanted: list[str]) -> dict[str, str]:
    """Build tests; return their programs by name."""
    command = ["cargo", "test", "--locked", "--no-run", "--message-format=json"]
    for name in wanted:
        command += ["--lib"] if name == "lib" else ["--test", name]
    done = subprocess.run(command, cwd=copy, stdout=subprocess.PIPE, text=True, check=True)
    found = {}
    for line in done.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable"):
            name = message["target"]["name"]
            found["lib" if "lib" in message["target"]["kind"] or name == "rustchain" else name] = (
                message["executable"]
            )
    return found


def processor_time() -> float:
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def tests_of(
    copy: Path, programs: dict[str, str], match: str, longest: float
) -> dict[int, list[tuple[float, str, str]]]:
    """Return processor time [s], program and name of the tests that reach each mutant.

    Tests that take more than `longest` [s] are ended and left out, as are those without `match`.
    """
    reaching: dict[int, list[tuple[float, str, str]]] = collections.defaultdict(list)
    report = copy / "reached"
    for program in programs.values():
        listed = subprocess.run([program, "--list"], capture_output=True, text=True, check=True)
        for test in re.findall(r"^(.+): test$", listed.stdout, re.MULTILINE):
            if not re.search(match, test):
                continue
            report.unlink(missing_ok=True)
            begin = processor_time()
            status = ends(copy, program, test, {"MUTANTS_REACHED": str(report)}, int(longest) + 1)
            if status == -signal.SIGKILL:
                continue
            if status:
                print("fails without a mutant:", program, test, flush=True)
            elif report.exists():
                takes = processor_time() - begin
                for number in report.read_text().split():
                    reaching[int(number)].append((takes, program, test))
    return reaching


def ends(copy: Path, program: str, test: str, environment: dict[str, str], limit: int = 600) -> int:
    """Run a test and return its exit status; it is killed behind `limit` [s] of processor time."""

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

    done = subprocess.run(
        [program, "--exact", test],
        env={**os.environ, **environment},
        cwd=copy,
        capture_output=True,
        check=False,
        preexec_fn=limited,
    )
    return done.returncode


def run(copy: Path, wanted: list[str], match: str, only: str, longest: float, out: Path) -> None:
    """Run the tests that reach each mutant and take less than `longest` [s] without it."""
    names = json.loads((copy / "mutants.json").read_text())
    reaching = tests_of(copy, binaries(copy, wanted), match, longest)
    print(len(names), "mutants,", len(reaching), "reached", flush=True)
    states: dict[str, str] = json.loads(out.read_text()) if out.exists() else {}

    def state_of(number: int) -> str:
        for takes, program, test in sorted(reaching[number]):
            if takes > longest:
                break
            limit = int(LIMIT * takes + 5.0)
            if status := ends(copy, program, test, {"MUTANT": str(number)}, limit):
                return f"{'timed out' if status == -signal.SIGKILL else 'killed'} by {test}"
        return "survived"

    for number, name in enumerate(names):
        ended = states.get(name, "").startswith(("killed", "timed out"))
        if number in reaching and not ended and re.search(only, name):
            states[name] = state_of(number)
        states.setdefault(name, "not reached")
        if number % 20 == 0:
            out.write_text(json.dumps(states, indent=0))
    out.write_text(json.dumps(states, indent=0))
    table = collections.defaultdict(collections.Counter)
    for name, state in states.items():
        table[name.split(":")[0]][state.split(" by ")[0]] += 1
        if state == "survived":
            print("survived:", name)
    for path, counts in table.items():
        print(path, dict(counts))


def main() -> None:
    """Make mutants, or run tests with them."""
    parser = argparse.ArgumentParser(description=__doc__)
    kinds = parser.add_subparsers(dest="kind", required=True)
    making = kinds.add_parser("make")
    making.add_argument("copy", type=Path)
    making.add_argument("files", nargs="+")
    making.add_argument("--one-in", type=int, default=1, help="take one of this many mutants")
    running = kinds.add_parser("run")
    running.add_argument("copy", type=Path)
    running.add_argument("--tests", nargs="+", default=["lib"])
    running.add_argument("--match", default="", help="expression that names of tests have")
    running.add_argument("--only", default="", help="expression that names of mutants have")
    running.add_argument("--longest", type=float, default=600.0, help="processor time [s]")
    running.add_argument("--out", type=Path, default=None, help="states, kept between runs")
    given = parser.parse_args()
    if given.kind == "make":
        make(given.copy.resolve(), given.files, given.one_in)
    else:
        out = given.out or given.copy / "states.json"
        run(given.copy.resolve(), given.tests, given.match, given.only, given.longest, out)


if __name__ == "__main__":
    main()
