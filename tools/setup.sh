#!/bin/sh
# Make this checkout ready to run: system packages, .venv, locked Python packages; for the tests compiled kernels, too.
#
#   tools/setup.sh play     what a show needs
#   tools/setup.sh bench    that, and what the benches compare with
#   tools/setup.sh docs     what a show needs, and what builds the documentation
#   tools/setup.sh test     what a show needs, and what the tests do (a virtual screen and sound card, linters, pytest)
#
# Environment:
#   PYTHON=python3.12       use this interpreter instead of the newest of 3.11 to 3.14 on which everything works
#   SETUP_YES=1             install missing system packages without asking (as root without a terminal, too)
#   SETUP_SKIP_SYSTEM=1     leave the system packages alone
#   SETUP_DRY_RUN=1         print what would be installed and stop
# pip's and uv's own settings (PIP_*, UV_*, pip.conf, uv.toml) are respected.
#
# Once all is done a stamp file .venv/.ready-* says so, and the next run costs a few milliseconds.
set -eu
cd "$(dirname "$0")/.."

mode=${1:-play}
case $mode in
  play | bench | docs | test) ;;
  *)
    echo "usage: tools/setup.sh play|bench|docs|test" >&2
    exit 2
    ;;
esac
dry_run=${SETUP_DRY_RUN:-}

say() { printf '%s\n' "$*" >&2; }
die() {
  say "setup: $*"
  exit 1
}

# --- system packages -----------------------------------------------------------------------------------------------
# "a|b" = b where a is not known (names differ between releases). Windows: GLFW loads the libX* by name at run time.
apt_play="libegl1 libgl1 libasound2t64|libasound2 libportaudio2 libatomic1
  libx11-6 libxcursor1 libxi6 libxinerama1 libxrandr2"
apt_test="xserver-xorg-core xserver-xorg-video-dummy x11-xserver-utils xdotool imagemagick
  pulseaudio pulseaudio-utils libasound2-plugins jackd2 liblo-tools iproute2
  libfluidsynth3 timgm6mb-soundfont chromium|chromium-browser"
dnf_play="libglvnd-egl libglvnd-glx mesa-libEGL mesa-libGL mesa-dri-drivers alsa-lib portaudio libatomic
  libX11 libXcursor libXi libXinerama libXrandr"
dnf_test="xorg-x11-server-Xorg xorg-x11-drv-dummy xrandr xdotool ImageMagick pulseaudio pulseaudio-utils
  alsa-plugins-pulseaudio liblo iproute chromium"
brew_play="portaudio"
brew_test="liblo"

find_package_system() {
  if command -v apt-get >/dev/null 2>&1; then
    echo apt
  elif command -v dnf >/dev/null 2>&1; then
    echo dnf
  elif command -v brew >/dev/null 2>&1; then
    echo brew
  else
    echo none
  fi
}

is_installed() {
  case $packages in
    apt) dpkg-query -W -f='${db:Status-Status}\n' "$1" 2>/dev/null | grep -qx installed ;;
    dnf) rpm -q --quiet "$1" 2>/dev/null ;;
    brew) brew list --versions "$1" >/dev/null 2>&1 ;;
  esac
}

# Those of "$@" that are not installed; of "a|b" neither is, and then both are printed again.
list_missing() {
  for package in "$@"; do
    if ! is_installed "${package%%|*}" && ! is_installed "${package##*|}"; then
      printf ' %s' "$package"
    fi
  done
}

# "a|b" becomes a where apt knows it (a real package, not only a name that others provide), else b.
choose_names() {
  for package in "$@"; do
    case $package in
      *"|"*)
        if apt-cache show --no-all-versions "${package%%|*}" 2>/dev/null | grep -q '^Filename:'; then
          printf ' %s' "${package%%|*}"
        else
          printf ' %s' "${package##*|}"
        fi
        ;;
      *) printf ' %s' "$package" ;;
    esac
  done
}

is_root() { [ "$(id -u)" = 0 ]; }

# Nobody's system is changed unasked; where nobody can be asked, root is a container's or a build machine's.
# shellcheck disable=SC2086
may_install() {
  [ -z "${SETUP_YES:-}" ] || return 0
  if ! { [ -t 0 ] && [ -t 2 ]; }; then
    is_root
    return
  fi
  say "setup: these system packages are missing:$(choose_names $missing)"
  printf 'Install these now? [Y/n] ' >&2
  read -r answer || answer=no
  case $answer in "" | [yY]*) return 0 ;; *) return 1 ;; esac
}

become_root() { # sets $sudo to a prefix that makes root, or fails
  sudo=
  is_root && return 0
  command -v sudo >/dev/null 2>&1 || return 1
  if sudo -n true 2>/dev/null; then
    sudo="sudo -n"
  elif [ -t 0 ] && [ -t 2 ]; then
    say "setup: installing system packages needs your password (Ctrl-C: install them yourself)"
    sudo -v || return 1
    sudo="sudo"
  else
    return 1
  fi
}

# --no-remove: an installation that would take something away (PipeWire's bridges, say) is refused by apt itself.
apt_install() {
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends --no-remove "$@" >&2
}

apt_knows() {
  for package in "$@"; do
    apt-cache show --no-all-versions "$package" >/dev/null 2>&1 || return 1
  done
}

# shellcheck disable=SC2046,SC2086 # lists of package names are meant to be split
install_with_apt() {
  if ! apt_knows $(choose_names $missing); then
    say "setup: apt-get update"
    $sudo apt-get update -qq >&2 || say "setup: apt-get update failed; trying with the lists that are there"
  fi
  chosen=$(choose_names $missing)
  say "setup: apt-get install$chosen"
  apt_install $chosen && return 0
  # An old list names versions that the mirror has dropped: fresh lists, once more.
  $sudo apt-get update -qq >&2 || true
  chosen=$(choose_names $missing)
  apt_install $chosen && return 0
  [ "$mode" = test ] || return 1
  for package in $chosen; do # the tests take what they can get
    apt_install "$package" || say "setup: could not install $package"
  done
  [ -z "$(list_missing $missing)" ]
}

# shellcheck disable=SC2086
print_line() {
  case $packages in
    apt) say "  sudo apt-get install --no-install-recommends$(choose_names $missing)" ;;
    dnf) say "  sudo dnf install$missing" ;;
    brew) say "  brew install$missing" ;;
  esac
}

# shellcheck disable=SC2046,SC2086
system_packages() { # $1 = play or test; fails when something is missing still
  case $packages-$1 in
    apt-play) missing=$(list_missing $apt_play $(venv_package)) ;;
    apt-test) missing=$(list_missing $apt_test) ;;
    dnf-play) missing=$(list_missing $dnf_play) ;;
    dnf-test) missing=$(list_missing $dnf_test) ;;
    brew-play) missing=$(list_missing $brew_play) ;;
    brew-test) missing=$(list_missing $brew_test) ;;
    none-*)
      say "setup: no apt, dnf or brew here; a show needs the libraries EGL, GL (Mesa), ALSA, PortAudio and X11"
      say "       with Xcursor, Xi, Xinerama and Xrandr. Going on; \`.venv/bin/live doctor\` tells what is missing."
      return 0
      ;;
  esac
  if [ -n "$dry_run" ]; then
    if [ -n "$missing" ]; then print_line; else say "  ($1: no system package is missing)"; fi
    return 0
  fi
  [ -n "$missing" ] || return 0
  if [ "$packages" = apt ] && may_install && become_root; then
    install_with_apt && return 0
    missing=$(list_missing $missing)
    say "setup: apt-get could not install these; its messages above say why. By hand:"
  else
    say "setup: these system packages are missing. Please type, then run the same command again:"
  fi
  print_line
  return 1
}

# --- Python --------------------------------------------------------------------------------------------------------
python_version() { "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null; }

can_make_venv() { "$1" -c 'import ensurepip, venv' 2>/dev/null; }

# $1 = version: the lock has a wheel of Ableton Link for it. Of a new Python there is none for a while.
has_link() { grep -q "/linkpython_extern-[^/]*-cp$(echo "$1" | tr -d .)-" uv.lock; }

# The newest interpreter that can make a .venv at once and on which everything works; else one that can make a .venv;
# else one on which everything works, but that needs a package first; else the newest.
find_python() {
  [ -z "${PYTHON:-}" ] || {
    echo "$PYTHON"
    return
  }
  at_once=
  later=
  newest=
  for name in python3.14 python3.13 python3.12 python3.11 python3; do
    version=$(python_version "$name") || continue
    case $version in 3.1[1-4]) ;; *) continue ;; esac
    if can_make_venv "$name"; then
      if has_link "$version"; then
        echo "$name"
        return
      fi
      at_once=${at_once:-$name}
    elif has_link "$version"; then
      later=${later:-$name}
    fi
    newest=${newest:-$name}
  done
  echo "${at_once:-${later:-$newest}}"
}

# Debian keeps ensurepip in a package of its own, named after the interpreter's version.
venv_package() {
  venv_works || can_make_venv "$python" || printf ' python%s-venv' "$(python_version "$python")"
}

venv_works() {
  [ -x .venv/bin/python ] || return 1
  case $(python_version .venv/bin/python) in 3.1[1-4]) ;; *) return 1 ;; esac
}

make_venv() {
  venv_works && return 0
  if [ -e .venv ]; then
    say "setup: .venv does not work any more; making it anew"
    rm -rf .venv
  fi
  say "setup: .venv with $(command -v "$python") ($(python_version "$python"))"
  "$python" -m venv .venv || die "could not make .venv; the message above says why"
}

# uv is of one version, whose files are known by their hashes: what the index hands out is that or nothing.
install_python_packages() {
  if [ ! -x .venv/bin/uv ]; then
    .venv/bin/python -m pip --version >/dev/null 2>&1 || .venv/bin/python -m ensurepip >&2
    PIP_DISABLE_PIP_VERSION_CHECK=1 .venv/bin/python -m pip install -q --require-hashes --only-binary=:all: \
      -r tools/uv-requirements.txt >&2 ||
      die "could not install uv from PyPI; is there a network, and a proxy to be set (HTTPS_PROXY, PIP_INDEX_URL)?"
  fi
  case $mode in
    play) more=--no-dev ;;
    bench) more="--no-dev --extra=bench" ;;
    docs) more="--no-dev --group=docs" ;;
    test) more="--group=dev --extra=bench" ;;
  esac
  made=$(python_version .venv/bin/python)
  if has_link "$made"; then
    # shellcheck disable=SC2086 # several options
    sync_packages --extra=link --extra=fast $more && return 0
    say "setup: once more without Ableton Link, of which not every machine has a wheel"
  else
    say "setup: Python $made: everything works but Ableton Link, of which the lock has no wheel for it. With Link: remove" \
      ".venv and use another Python, by PYTHON=python3.12 for instance"
  fi
  # shellcheck disable=SC2086
  sync_packages --extra=fast $more || die "could not install the locked packages; the message above says why"
}

sync_packages() {
  # --compile-bytecode: starting must not wait for the compiler of Python either.
  # --inexact: what else you installed in .venv stays, so `make play` does not undo `make test`.
  env -u VIRTUAL_ENV UV_PYTHON_DOWNLOADS=never UV_PROJECT_ENVIRONMENT="$PWD/.venv" \
    .venv/bin/uv sync --frozen --inexact --compile-bytecode --python "$PWD/.venv/bin/python" "$@" >&2
}

# --- all of it -----------------------------------------------------------------------------------------------------
stamp=".venv/.ready-$mode-$(cat uv.lock pyproject.toml tools/setup.sh tools/uv-requirements.txt | cksum | tr ' ' '-')"

if [ -n "$dry_run" ] || [ ! -e "$stamp" ] || ! venv_works; then
  packages=$(find_package_system)
  python=$(find_python)
  version=$(python_version "$python") || version=
  case $version in
    3.1[1-4]) ;;
    *)
      found=$(python_version python3) || found=none
      die "Python 3.11, 3.12, 3.13 or 3.14 is needed; found: ${PYTHON:+PYTHON=$PYTHON, }python3 $found.
       Debian 12, Ubuntu 24.04, Fedora 37 and all later ones bring it (package python3); macOS: brew install python@3.12"
      ;;
  esac
  system_ready=yes
  if [ -z "${SETUP_SKIP_SYSTEM:-}" ]; then
    system_packages play || exit 1
    if [ "$mode" = test ] && ! system_packages test; then
      say "setup: going on; tests that need them are skipped and say so"
      system_ready=
    fi
  fi
  if [ -n "$dry_run" ]; then
    say "  .venv with $python ($version), uv from PyPI, uv sync --frozen ($mode)"
    exit 0
  fi
  make_venv
  install_python_packages
  # What the tests of cameras need, once, in the user's folder. Everything else works without it.
  if [ "$mode" = test ] && ! .venv/bin/live camera models >/dev/null 2>&1; then
    say "setup: the pose models could not be fetched (live camera models says why); tests that need them are skipped"
  fi
  rm -f .venv/.ready-"$mode"-*
  [ -z "$system_ready" ] || : >"$stamp"
fi

# The studio's page is in the repository as it was built; only its tests need Node.
if [ "$mode" = test ] && [ -z "$dry_run" ] && command -v npm >/dev/null 2>&1; then
  built=studio/node_modules/.package-lock.json
  if [ ! -e "$built" ] || [ studio/package-lock.json -nt "$built" ]; then
    (cd studio && npm ci --ignore-scripts --no-audit --no-fund --silent >&2) ||
      say "setup: npm could not install what builds the studio; the tests of its sources are skipped"
  fi
fi

# Python's compiled files of the project itself, also where PYTHONDONTWRITEBYTECODE keeps Python from writing them: a
# show must not wait for its compiler at each start.
if [ ! -e .venv/.compiled ] || [ -n "$(find live -name '*.py' -newer .venv/.compiled)" ]; then
  .venv/bin/python -m compileall -q live && : >.venv/.compiled
fi

# A show compiles what it needs when it starts; tests would wait for it one by one. The compiled kernels lie in the
# user's cache, under names that follow their sources; the stamp names the file there that says they are complete.
if [ "$mode" = test ]; then
  kernels=".venv/.warm-$({
    find live -name "*kernels.py" -exec cat {} +
    echo "${LIVE_CACHE_DIR:-} ${XDG_CACHE_HOME:-} ${HOME:-}"
  } | cksum | tr ' ' '-')"
  if ! { [ -s "$kernels" ] && [ -e "$(cat "$kernels")" ] && [ -z "$(find live -name "*kernels.py" -newer "$kernels")" ]; }; then
    rm -f .venv/.warm-*
    .venv/bin/live warm --stamp "$kernels"
  fi
fi
