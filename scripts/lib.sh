# Shared by the scripts: the repository's root, Debian packages, the virtual environment.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
venv="$root/.venv"

say() { printf '== %s\n' "$*"; }

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# Prints those of the named Debian packages that are not installed.
missing_packages() {
  local package
  for package in "$@"; do
    if [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2> /dev/null)" != installed ]; then
      echo "$package"
    fi
  done
}

install_packages() {
  say "Installing Debian packages: $*"
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" > /dev/null
}

# Installs those of the named Debian packages that are missing.
need_packages() {
  if ! command -v dpkg-query > /dev/null; then
    say "This is not Debian; it needs what Debian calls: $*"
    return
  fi
  local missing
  mapfile -t missing < <(missing_packages "$@")
  if [ ${#missing[@]} -eq 0 ]; then
    say "Debian packages: all there"
    return
  fi
  as_root apt-get update -qq
  install_packages "${missing[@]}"
}

# Installs a Debian package that is missing, unless this release has none of that name: what for is said then.
offer_package() {
  local package="$1" purpose="$2"
  if command -v dpkg-query > /dev/null && [ -z "$(missing_packages "$package")" ]; then return; fi
  if command -v apt-get > /dev/null; then
    as_root apt-get update -qq
    if apt-cache show "$package" > /dev/null 2>&1; then
      install_packages "$package"
      return
    fi
  fi
  say "There is no package $package here, so: $purpose"
}

# The packages that a Python environment needs, if this machine's python3 can't make one yet.
python_packages() {
  if ! command -v python3 > /dev/null; then
    echo python3 python3-venv
  elif ! python3 -c 'import ensurepip, venv' 2> /dev/null; then
    echo python3-venv
  fi
}

make_venv() {
  if ! python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))'; then
    echo "rvdnav needs Python 3.10 or later; python3 is $(python3 --version)" >&2
    exit 1
  fi
  if ! "$venv/bin/python" -c '' 2> /dev/null; then
    say "Making a virtual environment in .venv"
    python3 -m venv --clear "$venv"
  fi
}

quiet_pip() {
  "$venv/bin/python" -m pip --quiet --quiet --disable-pip-version-check install "$@"
}

# What the installed package was made from: the compiled part's files, and which Python files there are.
source_stamp() {
  (cd "$root" && {
    find pyproject.toml CMakeLists.txt cmake csrc include python/CMakeLists.txt -type f -print0 |
      sort -z | xargs -0 sha256sum
    find python/rvdnav -name '*.py' | sort
  } | sha256sum)
}

# install_package [EXTRA]: the package in the virtual environment, Python files in place, compiled part up to date.
install_package() {
  local extra="${1:-}" stamp mark
  stamp="$(source_stamp)"
  mark="$venv/installed${extra:+-$extra}"
  if [ -e "$mark" ] && [ "$(cat "$mark")" = "$stamp" ]; then
    say "Python package: up to date"
    return
  fi
  say "Installing build tools into .venv: scikit-build-core, cffi, cmake, ninja"
  quiet_pip 'scikit-build-core>=0.10' 'cffi>=1.15' 'cmake>=3.25' ninja
  say "Building rvdnav, installing it and its dependencies into .venv${extra:+ (with the extra '$extra')}"
  quiet_pip --no-build-isolation --editable "$root${extra:+[$extra]}"
  printf '%s\n' "$stamp" | tee "$venv/installed" > "$mark"
}
