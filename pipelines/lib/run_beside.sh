#!/bin/bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Commands are symbolic links to this script: it runs the Python module beside the link that has the link's name.
set -uo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
. "$root/pipelines/lib/setup.sh"
folder=$(cd "$(dirname "$0")" && pwd -P)
module=${folder#"$root/"}/${0##*/}
run_module "${module//\//.}" "$@"
