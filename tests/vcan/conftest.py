"""Everything here needs SocketCAN with vcan0 and vcan1; elsewhere it is skipped with the command that runs it."""

import shutil
from pathlib import Path

import pytest

from bench.links.available import interface_is_up, kernel_has_can

HERE = Path(__file__).parent


def reason_to_skip() -> str:
    """Why the tests of this folder cannot run here, or an empty text."""
    if kernel_has_can() and interface_is_up("vcan0") and interface_is_up("vcan1"):
        return ""
    missing = [
        package
        for package, file in (
            ("user-mode-linux", "/usr/bin/linux.uml"),
            ("kmod", shutil.which("insmod") or "/usr/sbin/insmod"),
            ("can-utils", shutil.which("candump") or "/usr/bin/candump"),
        )
        if not Path(file).exists()
    ]
    install = f"sudo apt-get install {' '.join(missing)} && " if missing else ""
    return f"no vcan0 and vcan1 here; run: {install}make vcan"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    reason = reason_to_skip()
    for item in items:
        if HERE in Path(item.path).parents:
            item.add_marker(pytest.mark.vcan)
            if reason:
                item.add_marker(pytest.mark.skip(reason=reason))
