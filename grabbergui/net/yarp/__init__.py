"""YARP without YARP: names, ports, carriers and messages in pure Python, and the frame grabber on top.

The wire is YARP 3.12's and 4.0's. In `os`, codecs and protocols (`values`, `bottle`, `carrier`, `codecs`,
`framing`, `connection`, `admin`) do no I/O; `sockets`, `link`, `name_client`, `name_server` and the ports
(`port`, `ports`, `inputs`, `outputs`, `registry`) hold the sockets and threads. `image` has YARP's images.
`grabber_rpc`, `grabber_values`, `grabber_service` and `grabber_link` are the frame grabber's RPC, in two
dialects; `server` shares a grabber, `client` uses a remote one.
"""
