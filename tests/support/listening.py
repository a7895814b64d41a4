"""Waiting for ports of YARP's own programs."""

from grabbergui.core.errors import GrabberError
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.link import administer
from grabbergui.net.yarp.os.values import Vocab


def listens(names, name):
    """A YARP port is registered before it listens; only an answer shows that it does."""
    try:
        return bool(administer(names.query(name).address, Bottle([Vocab("ver")])))
    except GrabberError:
        return False
