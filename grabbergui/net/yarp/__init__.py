"""YARP without YARP: names, ports, carriers and messages in pure Python, and the frame grabber on top.

The wire is YARP 3.12's and 4.0's. Codecs and machines (`bottle`, `image`, `carrier`, `receiver`, `names`,
`admin`, `auth`, `mjpeg`, `web_page`) do no I/O; `name_client`, `name_server`, `registration`, `rpc_client`
and the ports (`port`, `ports`, `inputs`, `outputs`) hold the sockets and threads.
"""
