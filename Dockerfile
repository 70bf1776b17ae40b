# A bare Debian in which everything is built and tested:
#   docker build --build-arg DEBIAN=13 -t rekindle . && docker run --rm rekindle
# A volume at /src/.cache keeps what ccache has compiled. Not as root: some tests are about files that may not
# be read.
ARG DEBIAN=12
FROM debian:${DEBIAN}

COPY .ci/install /tmp/install
RUN apt-get update && apt-get install -y --no-install-recommends ca-certificates git && /tmp/install \
    && { apt-get install -y --no-install-recommends clang-format-14 || true; } \
    && rm -rf /var/lib/apt/lists/* /tmp/install

RUN useradd --home-dir /src builder && install -d -o builder /src /src/.cache /src/rekindle
USER builder
ENV HOME=/src
WORKDIR /src/rekindle
COPY --chown=builder . .
CMD [".ci/run"]
