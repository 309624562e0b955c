# voz in a container: sound by the socket of PulseAudio or PipeWire. See docs/docker.md.
#
#   docker build -t voz .
#   docker build -t voz --build-arg EXTRAS='[ros2]' .     with ROS 2, on x86-64

FROM debian:bookworm-slim

# festival speaks, PortAudio reaches the sound server by ALSA's plug-in, pactl lists its sources.
RUN apt-get update \
    && apt-get install -y --no-install-recommends \
        festival \
        espeak-ng \
        festvox-kallpc16k \
        libasound2-plugins \
        libportaudio2 \
        pulseaudio-utils \
        python3 \
        python3-venv \
    && rm -rf /var/lib/apt/lists/*

# All sound goes to the server outside, which shares no memory with the container, and none is started.
RUN printf 'pcm.!default { type pulse }\nctl.!default { type pulse }\n' > /etc/asound.conf \
    && printf 'enable-shm = no\nautospawn = no\n' > /etc/pulse/client.conf

ARG EXTRAS=
COPY pyproject.toml README.md LICENSE /opt/voz/
COPY voz /opt/voz/voz
RUN python3 -m venv /opt/venv \
    && /opt/venv/bin/python -m pip install --no-cache-dir --prefer-binary "/opt/voz${EXTRAS}" \
    && rm -rf /opt/voz

RUN useradd --create-home --uid 1000 robot
USER robot
WORKDIR /home/robot

ENV PATH=/opt/venv/bin:$PATH \
    PULSE_SERVER=unix:/run/pulse/native \
    PYTHONUNBUFFERED=1

# SIGTERM, as `docker stop` sends it: zero velocity is the last that goes out.
STOPSIGNAL SIGTERM
ENTRYPOINT ["voz"]
CMD ["run"]
