# One image for all federates; docker-compose.yml and deploy/chart start one a service. Scenes, airports and tables are in the executable.
FROM rust:1.95-bookworm AS build
WORKDIR /src
COPY . .
RUN cargo build --release --locked --bin seeds

FROM debian:bookworm-slim
COPY --from=build /src/target/release/seeds /usr/local/bin/
# Each federate under its own name, and a folder for recordings that the user below may write.
RUN for name in admin-station traffic-generator external-world smdfm control visitors viewer-logger gateway; do \
      printf '#!/bin/sh\nexec seeds %s "$@"\n' "$name" > "/usr/local/bin/$name" && chmod 755 "/usr/local/bin/$name"; \
    done && install -d -o 65534 -g 65534 /seeds/runs
WORKDIR /seeds
USER 65534:65534
ENTRYPOINT ["seeds"]
