#!/usr/bin/env bash
# What bash completes, asked as bash asks it, against --help; and that zsh's script has the same options
# and is read by zsh where there is one.
#   test_completion.sh REFRAME
set -euo pipefail
reframe=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

fail() { echo "test_completion: $*" >&2; exit 1; }

"$reframe" completion bash >"$folder/reframe.bash"
"$reframe" completion zsh >"$folder/_reframe"
bash -n "$folder/reframe.bash"
# shellcheck disable=SC1091
source "$folder/reframe.bash"
complete -p reframe | grep -q -- '-F _reframe reframe' || fail "nothing is registered"

# completes WORD...: what the last word may become.
completes()
{
    COMP_WORDS=(reframe "$@")
    COMP_CWORD=$#
    _reframe
    echo "${COMPREPLY[*]-}"
}

# expect WANTED WORD...
expect()
{
    local wanted=$1
    shift
    local found
    found=$(completes "$@")
    [ "$found" = "$wanted" ] || fail "'$*' became '$found', not '$wanted'"
}

expect "render report reconstruct" re
expect "--version" --v
expect "exact eq15 unweighted" render a.glb --weights ""
expect "eq15" tune --weights eq
expect "eq15" tune --weights = eq
expect "exact eq15 unweighted" tune --weights =
expect "1080p 1440p" tune --size 1
expect "auto" render --group ""
expect "on off" render --adaptive o
expect "--overscan --overwrite" render --adaptive --ov
expect "--max-depth" cost --max
expect "--no-overlap" compare --no-o
expect "bash zsh" completion ""
expect "cost compare convert completion" help co
expect "" render --output ""   # files are bash's own affair
expect "" render ""
expect "" render --spp ""
expect "" nonsense --

count=0
commands=$("$reframe" --help | sed -n 's/^  \([a-z]\{1,\}\)  .*/\1/p')
for command in $commands; do
    [[ " $(completes "") " == *" $command "* ]] || fail "$command is not completed"
    grep -q "^        $command)$" "$folder/_reframe" || fail "zsh lacks $command"
    # --[no-]name is two options
    options=$("$reframe" "$command" --help | sed -n 's/^  \(-[a-zA-Z], \)\{0,1\}\(--[][a-z-]*\).*/\2/p' |
        sed 's/^--\[no-\]\(.*\)/--\1\n--no-\1/' | sort)
    [ "$options" = "$(completes "$command" -- | tr ' ' '\n' | sort)" ] || fail "$command: other options than in --help"
    zsh=$(sed -n "/^        $command)$/,/;;$/p" "$folder/_reframe" | grep -o -- "[)',]--[a-z-]*[]}=[]*" | grep -o -- '--[a-z-]*' | sort)
    [ "$options" = "$zsh" ] || fail "$command: zsh has other options than --help: $(diff <(echo "$options") <(echo "$zsh"))"
    count=$((count + $(wc -l <<<"$options")))
done
[ "$count" -gt 100 ] || fail "only $count options"
if command -v zsh >/dev/null; then zsh -n "$folder/_reframe"; fi
if "$reframe" completion fish >/dev/null 2>"$folder/said"; then fail "fish is no shell"; fi
grep -q "'fish': no such shell, there are bash and zsh" "$folder/said"
echo "test_completion: passed, $count options of $(wc -w <<<"$commands") commands"
