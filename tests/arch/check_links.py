#!/usr/bin/python3
"""Checks which libraries a program loads:  check_links.py PROGRAM FORBIDDEN...

Needs readelf (binutils). Fails too when the program loads nothing, for then it was not read.
"""

import re
import subprocess
import sys


def main():
    program, *forbidden = sys.argv[1:]
    table = subprocess.run(["readelf", "-d", program], capture_output=True, text=True, check=True)
    loaded = re.findall(r"\(NEEDED\).*\[(.+)\]", table.stdout)
    wrong = [lib for lib in loaded for word in forbidden if word in lib]
    for lib in wrong:
        print(f"{program} must not need {lib}")
    return 1 if wrong or not loaded else 0


if __name__ == "__main__":
    sys.exit(main())
