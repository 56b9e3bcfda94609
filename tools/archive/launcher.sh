#!/bin/sh
# Start ChoreoGraphics Live with the Python and the libraries of this folder, from wherever it lies. Nothing is written
# here. A library is taken from here only where the system has none; this changes nothing outside this process.
set -eu
here=$(dirname "$(readlink -f "$0")")
if [ ! -e /lib64/ld-linux-x86-64.so.2 ]; then
  echo "live: this archive needs Linux with the GNU C library on x86-64; elsewhere: pipx install choreographics-live" >&2
  exit 2
fi
have=$(/sbin/ldconfig -p 2>/dev/null || ldconfig -p 2>/dev/null || :)
libraries=$here/python/lib
for folder in "$here"/libraries/*; do
  case $have in *"	${folder##*/} (libc6,x86-64"*) ;; *) libraries=$libraries:$folder ;; esac
done
if [ ! -e /usr/share/alsa/alsa.conf ]; then
  alsa=$here/alsa
  case $alsa in
    *[!A-Za-z0-9._/+-]*) # ALSA splits names at spaces; this process stays, so its open folder is a name without them
      exec 9<"$alsa"
      alsa=/proc/$$/fd/9
      ;;
  esac
  export ALSA_CONFIG_DIR="$alsa"
fi
unset PYTHONPATH PYTHONHOME PYTHONSTARTUP
export LD_LIBRARY_PATH="$libraries${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" PYTHONNOUSERSITE=1 PYTHONDONTWRITEBYTECODE=1
exec "$here/python/bin/python3" -m live "$@"
