"""For every standard name in it, a file of the engine includes the standard header, directly or through headers of the project. The
release build does not show a missing include: it precompiles headers, and compiles several sources as one."""
import functools
import re

from tree import numbered, without_comments

FOLDERS = ("include", "src", "replay", "tools/scenes")
INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', re.MULTILINE)
NAME = re.compile(r"\bstd::(?:ranges::|this_thread::)?(?!ranges::|this_thread::)([A-Za-z_]\w*)")

CONTAINERS = "array deque map set span string string_view vector"
# (headers, names): each of the headers declares the names.
HOMES = [
    ("algorithm", "adjacent_find all_of any_of binary_search clamp copy copy_backward copy_if copy_n count count_if equal fill fill_n find find_if "
                  "is_sorted lower_bound max max_element merge min min_element minmax mismatch none_of nth_element partition remove_if reverse reverse_copy rotate "
                  "sort stable_sort swap_ranges transform unique upper_bound"),
    ("array", "to_array"),
    ("array tuple utility", "get tuple_element_t tuple_size_v"),
    ("atomic", "atomic atomic_ref memory_order_acquire memory_order_relaxed memory_order_release memory_order_seq_cst"),
    ("bit", "bit_cast bit_width countl_zero countr_zero endian has_single_bit popcount rotl rotr"),
    ("charconv", "from_chars to_chars"),
    ("cstdlib cmath", "abs"),
    ("cmath", "floor sqrt"),
    ("compare", "strong_ordering"),
    ("concepts", "convertible_to floating_point integral same_as signed_integral unsigned_integral"),
    ("condition_variable", "condition_variable"),
    ("cstddef", "byte max_align_t nullptr_t ptrdiff_t to_integer"),
    (f"cstddef cstdio cstdlib cstring {CONTAINERS}", "size_t"),
    ("cstdint", "int8_t int16_t int32_t int64_t intptr_t uint8_t uint16_t uint32_t uint64_t uintptr_t"),
    ("cstdio", "FILE fclose ferror fflush fopen fputs fread fseek ftell fwrite rewind"),
    ("cstdlib", "abort free malloc"),
    ("cstring", "memcmp memcpy memmove memset strcmp strerror strlen"),
    ("deque vector", "erase_if"),
    ("filesystem", "filesystem"),
    ("fstream", "ifstream ofstream"),
    ("functional", "function"),
    ("initializer_list vector string", "initializer_list"),
    (f"iterator {CONTAINERS}", "begin data end next prev size ssize"),
    ("limits", "numeric_limits"),
    ("memory", "construct_at destroy_at enable_shared_from_this make_shared make_unique shared_ptr unique_ptr weak_ptr"),
    ("mutex", "lock_guard mutex unique_lock"),
    ("new", "align_val_t bad_alloc launder nothrow"),
    ("numeric", "accumulate iota"),
    ("optional", "nullopt optional"),
    ("ostream iostream sstream", "ostream"),
    ("ios fstream iostream ostream sstream", "ios streamsize"),
    ("span", "as_bytes as_writable_bytes span"),
    ("string", "string to_string"),
    ("string string_view", "string_view"),
    ("system_error", "errc error_code generic_category system_category system_error"),
    ("thread", "sleep_for thread yield"),
    ("tuple", "tie tuple"),
    ("type_traits", "conditional_t invoke_result_t is_void_v decay_t has_unique_object_representations_v integral_constant is_constant_evaluated is_enum_v is_integral_v "
                    "is_same_v is_signed_v is_trivially_copyable_v remove_cvref_t remove_reference_t underlying_type_t"),
    ("utility", "cmp_greater cmp_less exchange in_range index_sequence integer_sequence make_index_sequence make_integer_sequence"),
    ("utility variant", "in_place_index in_place_type"),
    # Every standard library also declares these in the headers of the types that are moved, swapped or paired.
    ("utility algorithm functional map memory optional tuple variant array deque set string vector", "forward move pair swap"),
    ("variant", "get_if holds_alternative monostate variant variant_alternative_t variant_size_v visit"),
    *((name, name) for name in ("array", "bitset", "deque", "map", "set", "vector")),
]
HOMES_OF = {name: homes.split() for homes, names in HOMES for name in names.split()}


class Reach:
    """The standard headers that a file includes, directly or through other headers."""

    def __init__(self, tree):
        self.roots = [tree.root / folder for folder in ("include", "src", "", "tools")]
        self.known = {}

    def of(self, path):
        if path not in self.known:
            self.known[path] = set()  # the result for headers that include this file again
            text = without_comments(path.read_text(), keep_strings=True)
            self.known[path] = functools.reduce(set.union, (self.of_name(name) for name in INCLUDE.findall(text)), set())
        return self.known[path]

    def of_name(self, name):
        found = next((root / name for root in self.roots if (root / name).is_file()), None)
        return {name} if found is None else self.of(found)


def check(tree):
    reach, complaints = Reach(tree), []
    for path in tree.files(FOLDERS):
        told = set()
        for number, line in numbered(without_comments(path.read_text())):
            for name in NAME.findall(line):
                homes = HOMES_OF.get(name)
                if name in told or (homes and not reach.of(path).isdisjoint(homes)):
                    continue
                told.add(name)
                where = f"{tree.name(path)}:{number}: std::{name}"
                complaints.append(f"{where} is of <{homes[0]}>, which is not included" if homes
                                  else f"{where}: tests/tidy/includes.py has no header for it")
    return complaints


PLANTED = [
    ("a source without the header of what it calls", {"src/base/x.cpp": "#include <string>\nint f(int a) { return std::min(a, 1); }\n"}),
    ("a header that leaves it to its source", {"src/base/x.h": "#pragma once\nstd::uint32_t f();\n",
                                               "src/base/x.cpp": '#include <cstdint>\n#include "base/x.h"\n'}),
    ("a name that the check does not know", {"src/base/x.cpp": "#include <algorithm>\nint f() { return std::something_new(); }\n"}),
    ("an algorithm for ranges", {"src/base/x.cpp": "#include <vector>\nvoid f(std::vector<int>& v) { std::ranges::sort(v); }\n"}),
    ("a header that is only named in a comment", {"src/base/x.cpp": "// #include <cstdint>\nstd::uint32_t f();\n"}),
]
GOOD = [
    ("what is included", {"src/base/x.cpp": "#include <algorithm>\nint f(int a) { return std::min(a, 1); }\n"}),
    ("what another header includes", {"src/base/x.h": "#pragma once\n#include <cstdint>\n",
                                      "src/base/x.cpp": '#include "base/x.h"\nstd::uint32_t f();\n'}),
    ("what is only named in a comment", {"src/base/x.cpp": "// as std::sort does\n"}),
]
