#!/usr/bin/env bash
# Installs what the browser tests need: Chromium (where apt can) and three packages of the npm registry. Best effort:
# without them the tests say that they did not run.
set -uo pipefail
cd "$(dirname "$0")"

if ! command -v chromium chromium-browser google-chrome >/dev/null 2>&1; then
  if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
    (apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium fonts-noto-core) >/dev/null 2>&1 \
      || echo "browser: chromium could not be installed"
  elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    (sudo apt-get update -qq && sudo apt-get install -y -qq --no-install-recommends chromium) >/dev/null 2>&1 \
      || echo "browser: chromium could not be installed"
  else
    echo "browser: no chromium, and no right to install one"
  fi
fi

if command -v npm >/dev/null 2>&1; then
  npm ci --no-audit --no-fund --silent || echo "browser: the npm packages could not be installed"
else
  echo "browser: no npm"
fi
