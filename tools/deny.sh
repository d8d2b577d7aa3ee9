#!/usr/bin/env bash
# Checks the dependencies of every workspace here with cargo-deny, by the rules of deny.toml: licences, bans, sources, and
# advisories where their database can be fetched. Without it that is said, and the other checks decide.
#
#   tools/deny.sh        takes cargo-deny from PATH
set -euo pipefail
cd "$(dirname "$0")/.."

# A clone takes seconds; a network that drops packets silently would hold this up for minutes.
fetch_limit_s=60

checks=(bans licenses sources)
if timeout "$fetch_limit_s" cargo-deny --config deny.toml fetch db; then
    checks+=(advisories)
    advisories="checked"
else
    advisories="NOT CHECKED: the advisory database could not be fetched"
fi

for lock in Cargo.lock */Cargo.lock; do
    workspace=$(dirname "$lock")
    printf '%s: ' "$workspace"
    # Offline from here on, so that every workspace is judged by the same advisories.
    cargo fetch --quiet --locked --manifest-path "$workspace/Cargo.toml"
    cargo-deny --config deny.toml --manifest-path "$workspace/Cargo.toml" --offline --locked \
        check --hide-inclusion-graph "${checks[@]}"
done
echo "advisories: $advisories"
