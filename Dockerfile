# `grabbergui serve` and the library, without the window and its libraries.
#   docker build -t grabbergui .
#   docker run --rm --network host grabbergui serve gige: --yarp /grabber
# Cameras on the network need the host's network. For USB: --device /dev/bus/usb, and --user root or the group
# of the host's udev rule (--group-add). A camera_info file or an .ini is mounted at /data.
FROM python:3.12-slim-bookworm AS build
WORKDIR /source
COPY . .
RUN python -m venv /opt/grabbergui \
    && /opt/grabbergui/bin/pip install --no-cache-dir --no-deps . \
    && /opt/grabbergui/bin/python scripts/headless-requirements > /tmp/requirements.txt \
    && /opt/grabbergui/bin/pip install --no-cache-dir -r /tmp/requirements.txt

FROM python:3.12-slim-bookworm
COPY --from=build /opt/grabbergui /opt/grabbergui
RUN useradd --create-home camera && install -d -o camera /data && ln -s /opt/grabbergui/bin/grabbergui /usr/local/bin/
USER camera
WORKDIR /data
# Counters for Prometheus, if --metrics 0.0.0.0:9090 is given; YARP's name server, with --with-name-server.
EXPOSE 9090 10000
STOPSIGNAL SIGTERM
ENTRYPOINT ["grabbergui"]
CMD ["serve", "--help"]
