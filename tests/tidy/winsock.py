"""The sources that use sockets compile for Windows, too: mingw-w64 compiles src/net/udp and address.cpp of src/net. It has no libsodium, so the check
does not compile the rest of src/net, which calls no functions of the operating system."""
import shutil
import subprocess

COMPILER = "x86_64-w64-mingw32-g++-posix"
FLAGS = ["-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-Wold-style-cast", "-Werror"]


def missing():
    return None if shutil.which(COMPILER) else f"{COMPILER} is not installed (package g++-mingw-w64-x86-64)"


def check(tree):
    complaints = []
    for source in [*tree.files(("src/net/udp",), (".cpp",)), *tree.files(("src/net",), ("address.cpp",))]:
        command = [COMPILER, *FLAGS, f"-I{tree.root}/include", f"-I{tree.root}/src", str(source)]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode != 0:
            errors = [line for line in run.stderr.splitlines() if "error" in line] or ["?"]
            complaints.append(f"{tree.name(source)}:1: does not compile for Windows: {errors[0]}")
    return complaints


PLANTED = [
    ("a header that only POSIX has", {"src/net/udp/x.cpp": "#include <sys/socket.h>\nint f() { return AF_INET; }\n"}),
    ("a socket that is an int", {"src/net/udp/x.cpp": "#include <winsock2.h>\nint f() { return ::socket(AF_INET, SOCK_DGRAM, 0); }\n"}),
    ("an address by POSIX alone", {"src/net/address.cpp": "#include <arpa/inet.h>\n"}),
]
GOOD = [("a socket of Winsock", {"src/net/udp/x.cpp": "#include <winsock2.h>\nSOCKET f() { return ::socket(AF_INET, SOCK_DGRAM, 0); }\n"})]
