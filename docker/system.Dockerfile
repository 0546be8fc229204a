# The system in a container: a plain Ubuntu with what the set-up asks for, then the same set-up command that CI runs.
#   docker build -f docker/system.Dockerfile -t tethernet .
FROM ubuntu:24.04

RUN apt-get update \
    && apt-get install -y --no-install-recommends ca-certificates cmake g++ python3 python3-dev python3-venv \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /tethernet
COPY . .
RUN python3 -m bootstrap mission

ENTRYPOINT ["python3", "run_mission.py"]
