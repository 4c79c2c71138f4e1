# SPDX-License-Identifier: GPL-3.0-or-later
# W2W in a container, as a web app whose studies lie in /data/w2w_studies, or as the command line:
#   docker build -t w2w . && docker run --rm -p 127.0.0.1:8000:8000 -v "$PWD:/data" w2w
#   docker run --rm -v "$PWD:/data" w2w run /data/CLIPS --out /data/RESULTS
# procps: loky ends the children of its workers by pgrep.
# tools/bare_machine.sh replays the lines that begin with RUN in a bare Debian; the file Apptainer has the same.
FROM debian:bookworm-slim
RUN apt-get update && apt-get install -y --no-install-recommends python3 python3-venv ca-certificates procps libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libice6 libgl1 && rm -rf /var/lib/apt/lists/*
COPY . /w2w
RUN python3 -m venv /opt/w2w && PIP_CONSTRAINT=/w2w/constraints.txt /opt/w2w/bin/pip install --no-cache-dir "/w2w[blender,web]" /w2w/packages/studies && rm -rf /w2w
ENV PATH=/opt/w2w/bin:$PATH
WORKDIR /data
ENTRYPOINT ["w2w"]
CMD ["serve", "--host", "0.0.0.0"]
