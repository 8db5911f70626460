#!/usr/bin/python3
"""Loads a report.html in headless chromium and looks for what a reader would trip over.

    check_page.py report.html     exit code 77 where there is no chromium
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
PROBE = """<script>addEventListener("load",()=>{const images=[...document.images];
document.documentElement.dataset.images=images.length;
document.documentElement.dataset.broken=images.filter(i=>!(i.naturalWidth>0)).length;
document.documentElement.dataset.requests=performance.getEntriesByType("resource")
.filter(e=>!e.name.startsWith("data:")).length;
document.documentElement.dataset.strange=
(document.body.innerText.match(/\\b(nan|inf|infinity|undefined|null)\\b/gi)||[]).join(" ")});</script>"""


def complaints(page):
    chromium = shutil.which("chromium")
    with tempfile.TemporaryDirectory() as folder:
        probed = pathlib.Path(folder) / "report.html"
        probed.write_text(page.replace("</head>", PROBE + "</head>", 1), encoding="utf-8")
        run = subprocess.run(
            [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
             f"--user-data-dir={folder}/profile", "--dump-dom", probed.as_uri()],
            capture_output=True, text=True, timeout=50, check=True)
    seen = dict(re.findall(r'data-(\w+)="([^"]*)"', run.stdout.split(">", 2)[1]))
    if "images" not in seen:
        yield "the page was not loaded"
    for name in ("broken", "requests"):
        if seen.get(name) != "0":
            yield f"{name}: {seen.get(name)}"
    if seen.get("strange"):
        yield f"strange text: {seen['strange']}"
    for line in run.stderr.splitlines():
        if ":CONSOLE" in line:
            yield line
    if re.search(r"""(src|href)=["']?(https?:)?//""", page):
        yield "the page names an address outside itself"


def main():
    if shutil.which("chromium") is None:
        print("skipped: there is no chromium (apt-get install chromium)")
        return SKIPPED
    found = list(complaints(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")))
    print("\n".join(found) or "sound")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
