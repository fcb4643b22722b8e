# SPDX-License-Identifier: Zlib
"""An X server without a screen, and a client of it with a mouse and a keyboard: through Xlib and XTEST."""
import ctypes
import ctypes.util
import os
import shutil
import subprocess

KEYS = {" ": 0x20, ".": 0x2E, "Control": 0xFFE3, "Escape": 0xFF1B}  # keysyms; letters are their Latin-1 codes
CLIENT_MESSAGE = 33


class ClientMessage(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("message_type", ctypes.c_ulong),
                ("format", ctypes.c_int), ("data", ctypes.c_long * 5), ("padding", ctypes.c_long * 24)]


class Server:
    """Xvfb on a free display number, which `name` has."""

    def __init__(self):
        read, write = os.pipe()
        self.process = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
            pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as numbers:
            number = numbers.readline().strip()
        if not number:
            raise RuntimeError("Xvfb does not start")
        self.name = ":" + number

    def stop(self):
        self.process.terminate()
        self.process.wait()


def missing():
    """The Debian packages that are missing."""
    needs = [("xvfb", shutil.which("Xvfb")), ("libx11-6", ctypes.util.find_library("X11")),
             ("libxtst6", ctypes.util.find_library("Xtst"))]
    return [package for package, found in needs if not found]


class Client:
    """Moves the mouse and presses keys as a user does."""

    def __init__(self, server):
        self.x = ctypes.CDLL(ctypes.util.find_library("X11"))
        self.xtst = ctypes.CDLL(ctypes.util.find_library("Xtst"))
        self.x.XOpenDisplay.restype = ctypes.c_void_p
        self.x.XInternAtom.restype = self.x.XDefaultRootWindow.restype = ctypes.c_ulong
        self.display = ctypes.c_void_p(self.x.XOpenDisplay(server.name.encode()))
        if not self.display:
            raise RuntimeError("cannot reach the display " + server.name)

    def _send(self):
        self.x.XSync(self.display, 0)

    def move(self, x, y):
        self.xtst.XTestFakeMotionEvent(self.display, 0, int(x), int(y), ctypes.c_ulong(0))
        self._send()

    def button(self, number, down):
        self.xtst.XTestFakeButtonEvent(self.display, number, int(down), ctypes.c_ulong(0))
        self._send()

    def hold(self, key, down):
        code = self.x.XKeysymToKeycode(self.display, ctypes.c_ulong(KEYS.get(key) or ord(key.lower())))
        self.xtst.XTestFakeKeyEvent(self.display, int(code), int(down), ctypes.c_ulong(0))
        self._send()

    def press(self, key):
        self.hold(key, True)
        self.hold(key, False)

    def windows(self):
        """The windows on the screen."""
        root, parent = ctypes.c_ulong(), ctypes.c_ulong()
        children, count = ctypes.POINTER(ctypes.c_ulong)(), ctypes.c_uint()
        self.x.XQueryTree(self.display, ctypes.c_ulong(self.x.XDefaultRootWindow(self.display)),
                          ctypes.byref(root), ctypes.byref(parent), ctypes.byref(children), ctypes.byref(count))
        return [children[i] for i in range(count.value)]

    def title(self, window):
        name = ctypes.c_char_p()
        self.x.XFetchName(self.display, ctypes.c_ulong(window), ctypes.byref(name))
        return (name.value or b"").decode(errors="replace")

    def close(self, window):
        """Asks a window to close, as its button does."""
        message = ClientMessage(type=CLIENT_MESSAGE, window=window, format=32)
        message.message_type = self.x.XInternAtom(self.display, b"WM_PROTOCOLS", 0)
        message.data[0] = self.x.XInternAtom(self.display, b"WM_DELETE_WINDOW", 0)
        self.x.XSendEvent(self.display, ctypes.c_ulong(window), 0, ctypes.c_long(0), ctypes.byref(message))
        self._send()
