# wirewear in a container that needs no privilege: built from this folder, run as a user of its own on a read-only root.
#   docker build -t wirewear .
#   docker run --rm --read-only --tmpfs /tmp -v "$PWD":/work wirewear run steel_wires --fidelity quick
FROM python:3.11-slim-bookworm AS built
WORKDIR /source
COPY . .
RUN pip wheel --no-deps --wheel-dir /wheels .

FROM python:3.11-slim-bookworm
COPY tools/prepare_machine.sh constraints.txt /opt/
RUN sh /opt/prepare_machine.sh python && rm -rf /var/lib/apt/lists/*
COPY --from=built /wheels /opt/wheels
RUN pip install --no-cache-dir --constraint /opt/constraints.txt /opt/wheels/*.whl \
    && useradd --create-home tribologist && mkdir /work && chown tribologist /work
USER tribologist
# Compiled loops and condensed bodies are kept where it may write: mount a volume there to keep them for the next time.
ENV WIREWEAR_CACHE=/tmp/cache MPLCONFIGDIR=/tmp/cache/matplotlib
WORKDIR /work
ENTRYPOINT ["wirewear"]
