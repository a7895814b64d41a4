"""YARP without YARP: names, ports, carriers and messages in pure Python, and the frame grabber on top.

The wire is YARP 3.12's and 4.0's. In `os`, codecs and protocols (`bottle`, `carrier`, `codecs`, `framing`,
`connection`, `names`, `admin`, `mjpeg`) do no I/O; `name_client`, `name_server`, `link` and the ports
(`port`, `ports`, `inputs`, `outputs`) hold the sockets and threads. `dev` is the frame
grabber's RPC; `server` shares a grabber, `client` uses a remote one.
"""
