# One image with all executables; docker-compose.yml starts a federate a service.
FROM rust:1.95-bookworm AS build
WORKDIR /src
COPY . .
RUN cargo build --release --locked

FROM debian:bookworm-slim
WORKDIR /seeds
COPY --from=build /src/target/release/seeds /src/target/release/traffic-generator \
     /src/target/release/external-world /src/target/release/smdfm \
     /src/target/release/viewer-logger /src/target/release/admin-station \
     /src/target/release/visitors /src/target/release/gateway \
     /src/target/release/control /usr/local/bin/
COPY scenarios ./scenarios
USER nobody
ENTRYPOINT ["seeds"]
