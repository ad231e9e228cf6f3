#compdef reframe
# Completion of reframe for zsh, printed by: reframe completion zsh
_reframe()
{
    local -a commands
    commands=(
{{commands}}        'help:the options of a command'
    )
    if (( CURRENT == 2 )); then
        _describe command commands
        compadd -- --help --man --version
        return
    fi
    local command=$words[2]
    shift words
    (( CURRENT-- ))
    case $command in
        help) _describe command commands ;;
{{options}}    esac
}
# sourced, or loaded as the function itself
if [ "$funcstack[1]" = _reframe ]; then
    _reframe "$@"
else
    compdef _reframe reframe
fi
