# Completion of reframe for bash, printed by: reframe completion bash
_reframe()
{
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
    local command=${COMP_WORDS[1]} options= kind= words= commands='{{commands}}help'
    COMPREPLY=()
    # bash takes --name=value for three words
    if [ "$current" = = ]; then
        current=
    elif [ "$previous" = = ]; then
        previous=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W "$commands --help --man --version" -- "$current"))
        return
    fi
    case $command in
        help) kind=words words=$commands ;;
{{options}}    esac
    case $command:$previous in
{{values}}    esac
    case $kind in
        words | text) compopt +o default +o bashdefault 2>/dev/null ;;
    esac
    case $kind:$current in
        words:* | maybe:[!-]* | maybe:) COMPREPLY=($(compgen -W "$words" -- "$current")) ;;
        maybe:-* | :-*) COMPREPLY=($(compgen -W "$options" -- "$current")) ;;
    esac # files are bash's own affair
}
complete -o default -o bashdefault -F _reframe reframe
