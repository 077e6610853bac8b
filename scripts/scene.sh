#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# scene.sh file NAME: the path of a scene.  A bare name is looked up, with or without its ending, in
#   scenes/, build/scenes/ and ../shared/scenes/; anything else is a path.
# scene.sh name PATH: what outputs are called after it, its file name without a known ending.
# scene.sh rays RAYS: the same for rays, a kind with its number or a .npy file.
set -eu
readonly endings=(.gltf .glb .obj .ply .ply.zst)

find_scene() {
  local folder ending
  for folder in scenes build/scenes ../shared/scenes; do
    [[ -n "$1" && "$1" != */* ]] || break
    for ending in "${endings[@]}" ''; do
      if [[ -f "$folder/$1$ending" ]]; then
        printf '%s\n' "$folder/$1$ending"
        return
      fi
    done
  done
  printf '%s\n' "$1"
}

# The longest ending first: .ply.zst ends in no other.
name_of() {
  local name=${1##*/} ending
  for ending in "${endings[@]}"; do
    [[ "$name" == ?*"$ending" ]] && name=${name%"$ending"} && break
  done
  printf '%s\n' "$name"
}

case "$1" in
  file) find_scene "$2" ;;
  name) name_of "$2" ;;
  rays)
    name=${2##*/}
    name=${name%.npy}
    printf '%s\n' "${name//:/-}"
    ;;
esac
