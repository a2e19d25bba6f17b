#!/bin/sh
# Prints the scenario of a chain of N flexible links, hinged to each other and to the world, that is released
# horizontal and swings:   examples/chain_of_links/make.sh 8 > examples/chain_of_links/chain8.yaml
# Every link is a flexible body in a process of its own; its ends are bonded to small rigid blocks that carry the
# hinges, or, with   make.sh 8 junctions   , to frames without mass: ideal hinges between flexible bodies.
# The links lie along x and swing about y.
set -eu
links=${1:-2}
ends=${2:-blocks}
case $ends in
  blocks | junctions) ;;
  *) echo "make.sh: '$ends' is neither blocks nor junctions. Say, for example: make.sh 4 junctions" >&2; exit 2 ;;
esac
case $links in
  '' | *[!0-9]* | 0) echo "make.sh: '$links' is no number of links. Say, for example: make.sh 4" >&2; exit 2 ;;
esac

cat <<EOF
# yaml-language-server: \$schema=../../docs/scenario.schema.json
# A chain of $links flexible links, released horizontal. Made by: make.sh $links $ends
name: chain_of_$links
description: $links flexible links on hinges, released horizontal at rest under gravity.

run:
  duration_s: 0.5
  macro_step_s: 0.001

coupling:
  scheme: interface_jacobian

ports:
EOF
link=1
while [ "$link" -le "$links" ]; do
  echo "  - {name: root$link, body: root$link, flexible: link$link, node_set: left}"
  echo "  - {name: tip$link, body: tip$link, flexible: link$link, node_set: right}"
  link=$((link + 1))
done

cat <<EOF

mbs:
  gravity_m_per_s2: [0, 0, -9.81]
EOF
[ "$ends" = blocks ] && echo "  bodies:" || echo "  junctions:"
link=1
while [ "$link" -le "$links" ]; do
  for end in root tip; do
    [ $end = root ] && hinge=$((link - 1)) || hinge=$link
    x=$(awk "BEGIN { print 0.3 * $hinge }")
    own=""
    [ "$ends" = blocks ] && own=", mass_kg: 0.05, inertia_kg_m2: [2.0e-5, 2.0e-5, 2.0e-5]"
    echo "    - {name: $end$link$own, position_m: [$x, 0, 0]}"
  done
  link=$((link + 1))
done
echo "  joints:"
link=1
while [ "$link" -le "$links" ]; do
  x=$(awk "BEGIN { print 0.3 * ($link - 1) }")
  to=""
  [ "$link" -gt 1 ] && to=", body2: tip$((link - 1))"
  echo "    - {name: hinge$link, kind: hinge, body1: root$link$to, anchor_m: [$x, 0, 0], axis: [0, 1, 0]}"
  link=$((link + 1))
done

echo
echo "fem:"
link=1
while [ "$link" -le "$links" ]; do
  x=$(awk "BEGIN { print 0.3 * ($link - 0.5) }")
  cat <<EOF
  - name: link$link
    # A bar of 0.3 m x 0.03 m x 0.03 m.
    mesh: {file: ../slider_crank/rod.msh, length_scale_m: 0.6, position_m: [$x, 0, 0]}
    material: {young_Pa: 5.0e+7, poisson: 0.3, density_kg_per_m3: 1100}
    gravity_m_per_s2: [0, 0, -9.81]
EOF
  link=$((link + 1))
done
