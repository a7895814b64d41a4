"""YARP without YARP: names, ports, carriers and messages in pure Python, and the frame grabber on top.

The wire is YARP 3.12's and 4.0's. Codecs and machines (`bottle`, `image`, `carrier`, `names`, `admin`, `auth`)
do no I/O; `name_client`, `name_server` and the files of ports hold the sockets and threads.
"""
