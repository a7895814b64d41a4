"""The doctor's checks find problems and name the remedies."""

from grabbergui.cli import main
from grabbergui.doctor.findings import Level
from grabbergui.doctor.usb import udev_rule
from grabbergui.setup.udev_rule import install_udev_rule


def only(findings):
    (finding,) = findings
    return finding


def test_the_udev_rule_is_installed_once(tmp_path):
    folder = tmp_path / "udev" / "rules.d"
    folder.parent.mkdir()
    assert "setup udev" in only(udev_rule(folder)).remedy

    target = install_udev_rule(folder)

    assert 'SUBSYSTEM!="usb"' in target.read_text()
    assert only(udev_rule(folder)).level is Level.GOOD


def test_the_command_reports_every_check(capsys):
    code = main(["doctor"])

    out = capsys.readouterr().out
    assert code == ("\nproblem" in "\n" + out)
    assert "USB" in out and "YARP" in out and "ROS 2" in out
