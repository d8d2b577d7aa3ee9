# docker build --tag fingerpost . && docker run --rm --user "$(id -u):$(id -g)" --volume "$PWD:/data" fingerpost demo
FROM rust:1.95-bookworm AS build
WORKDIR /source
COPY . .
RUN cargo build --release --locked --package fingerpost-cli

FROM debian:bookworm-slim
# hadolint ignore=DL3008
RUN apt-get update && apt-get install --yes --no-install-recommends ffmpeg \
    && rm -rf /var/lib/apt/lists/* && install --directory --owner=1000 /data
COPY --from=build /source/target/release/fingerpost /usr/local/bin/fingerpost
USER 1000:1000
WORKDIR /data
ENTRYPOINT ["fingerpost"]
