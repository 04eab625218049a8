# halfphysics in a container; results are written to the folder that is mounted at /work.
#
#   docker build -t halfphysics .
#   docker run --rm -v "$PWD:/work" halfphysics demo
#   docker run --rm -v "$PWD:/work" -p 127.0.0.1:8080:8080 halfphysics view out/demo/result.npz --host 0.0.0.0
FROM python:3.13-slim AS build
RUN apt-get update && apt-get install -y --no-install-recommends g++
COPY . /src
RUN pip wheel --no-deps -w /wheel /src

FROM python:3.13-slim
RUN --mount=from=build,source=/wheel,target=/wheel \
    pip install --no-cache-dir --only-binary :all: /wheel/*.whl
ENV HALFPHYSICS_CACHE=/tmp/halfphysics
WORKDIR /work
ENTRYPOINT ["halfphysics"]
CMD ["--help"]
