#!/bin/bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Commands are symbolic links to this script: it runs the Python module beside the link that has the link's name.
set -uo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
. "$root/pipelines/lib/setup.sh"
path=$0
# A user's own link leads to the command, not to the module.
while folder=$(cd "$(dirname "$path")" && pwd -P) && [[ $folder != "$root"/* ]]; do
  target=$(readlink "$path") || { echo "$path: link to it instead of copying it" >&2; exit 1; }
  path=$([[ $target == /* ]] || echo "$folder/")$target
done
module=${folder#"$root/"}/${path##*/}
run_module "${module//\//.}" "$@"
