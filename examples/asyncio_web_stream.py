"""Stream a camera to browsers as motion JPEG: python asyncio_web_stream.py sim:scene 8080."""

import asyncio
import contextlib
import signal
import sys

import cv2

import grabbergui

source, port = (*sys.argv[1:], *("sim:scene", "8080")[len(sys.argv) - 1 :])


async def show(_: asyncio.StreamReader, browser: asyncio.StreamWriter) -> None:
    """Send frames until the browser leaves, or Ctrl+C."""
    with contextlib.closing(browser), contextlib.suppress(ConnectionError, asyncio.CancelledError):
        browser.write(b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n\r\n")
        async for frame in camera.aframes():
            jpeg = cv2.imencode(".jpg", cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR))[1].tobytes()
            browser.write(b"--next\r\nContent-Type: image/jpeg\r\n\r\n" + jpeg + b"\r\n")
            await browser.drain()


async def main() -> None:
    """Serve until Ctrl+C, which ends the streams to the browsers, too."""
    loop, ended = asyncio.get_running_loop(), asyncio.Event()
    signal.signal(signal.SIGINT, lambda *_: loop.call_soon_threadsafe(ended.set))
    await asyncio.start_server(show, "127.0.0.1", int(port))
    print(f"open http://127.0.0.1:{port} in a browser; Ctrl+C ends")
    await ended.wait()


with grabbergui.open(source) as camera:
    asyncio.run(main())
