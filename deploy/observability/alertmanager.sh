#!/bin/sh
# Starts Alertmanager with alertmanager.yaml, which lies beside this, and with RECEIVER, the URL of a webhook, in place of the
# one there. Such a URL is often a secret. It has no default: alerts would go nowhere, and nobody would know.
# usage: alertmanager.sh [OPTION...]      options are those of alertmanager
set -eu

: "${RECEIVER:?set it to the URL of the webhook that is told of alerts}"
to=$(printf %s "$RECEIVER" | sed 's/[&|\\]/\\&/g')
umask 077
sed "s|http://receiver.invalid/|$to|" "$(dirname "$0")/alertmanager.yaml" > "${TMPDIR:-/tmp}/alertmanager.yaml"
exec alertmanager --config.file="${TMPDIR:-/tmp}/alertmanager.yaml" "$@"
