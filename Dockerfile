# SPDX-License-Identifier: LGPL-3.0-or-later
# docker build -t grus . && docker run --rm -v "$PWD":/work grus grus-rve scene.toml
FROM debian:12 AS build
COPY . /grus
WORKDIR /grus
ENV DEBFULLNAME="Grus in Docker" DEBEMAIL=root@localhost
RUN ./bootstrap build && apt-get install -y -q --no-install-recommends dpkg-dev && cd build && cpack -G DEB

FROM debian:12
COPY --from=build /grus/build/*.deb /packages/
RUN apt-get update -q && apt-get install -y -q --no-install-recommends /packages/grus_*.deb /packages/python3-grus_*.deb && rm -rf /packages /var/lib/apt/lists/*
ENV OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
WORKDIR /work
