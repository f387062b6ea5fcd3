# completion of flexmb for bash; made by `flexmb completion bash`
_flexmb() {
    local word="${COMP_WORDS[COMP_CWORD]}"
@CASES@
    if [ "$COMP_CWORD" -eq 1 ]; then
        names="@COMMANDS@" ending=""
    elif [[ "$word" == -* ]]; then
        names="$options" ending=""
    elif [ "$COMP_CWORD" -ne 2 ]; then
        names="" ending=""
    fi
    COMPREPLY=($(compgen -W "$names" -- "$word"))
    if [ -n "$ending" ]; then
        COMPREPLY+=($(compgen -f -X "!*$ending" -- "$word") $(compgen -d -S / -- "$word"))
    fi
}
complete -o default -F _flexmb flexmb
