#compdef flexmb
# completion of flexmb for zsh; made by `flexmb completion zsh`
_flexmb() {
@CASES@
    if (( CURRENT == 2 )); then
        compadd -- @COMMANDS@
    elif [[ "$PREFIX" == -* ]]; then
        compadd -- ${=options}
    elif (( CURRENT == 3 )); then
        [[ -n "$names" ]] && compadd -- ${=names}
        [[ -n "$ending" ]] && _files -g "*$ending"
    else
        _files
    fi
}
if [[ "${funcstack[1]}" == "_flexmb" ]]; then _flexmb "$@"; else compdef _flexmb flexmb; fi
