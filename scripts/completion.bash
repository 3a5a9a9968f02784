# SPDX-License-Identifier: Apache-2.0
# Completes the words of tactel in bash: commands, options, choices and files, as `tactel COMMAND --help` lists them.
# An installation has this file as share/bash-completion/completions/tactel; source it to use a build tree.

# Reads the help of "$@" into commands, options, types (by option) and positional (all types) of _tactel.
_tactel_read_help() {
  local line section='' entry name
  commands=() options=() types=() positional=
  while IFS= read -r line; do
    case $line in
      [A-Z]*:) section=$line ;;
      '  '[^\ ]*)
        entry=${line#  } && entry=${entry%%  *}
        case $section,$entry in
          Examples:,*) ;;
          *,-*)
            for name in ${entry//,/}; do
              [[ $name == -* ]] && options+=("$name") types[$name]=
            done
            [[ $name == -* ]] || for name in ${entry//,/}; do types[$name]=${entry##* }; done ;;
          Input:,*) positional+="|${entry#* }" ;;
          *) commands+=("$entry") ;;
        esac ;;
    esac
  done < <("$@" --help 2> /dev/null)
}

# Offers what the type of a value allows: "set|frame", "FILE.svg|png", "DIR|FILE.onnx"; nothing for "NUMBER". The help
# has no room for the choices of --rung: its refusal lists them.
_tactel_value() {
  local kind
  if [[ $1 == NAME ]]; then
    kind=$("${command[0]}" generate "$previous" '?' 2>&1)
    kind=${kind#*must be one of } kind=${kind%%$'\n'*}
    mapfile -t COMPREPLY < <(compgen -W "${kind//,/}" -- "$word")
  elif [[ $1 == SOURCE ]]; then
    compopt -o nospace 2> /dev/null
    mapfile -t COMPREPLY < <(compgen -W 'usb: csv: replay: simulate:' -- "$word")
  elif [[ $1 =~ ^[a-z0-9|-]+$ ]]; then
    mapfile -t COMPREPLY < <(compgen -W "${1//|/ }" -- "$word")
  elif [[ $1 == *.* || $1 == *FILE* || $1 == *DIR* ]]; then
    compopt -o filenames 2> /dev/null
    mapfile -t COMPREPLY < <(compgen -d -- "$word"
      [[ $1 == *.* ]] || compgen -f -- "$word"
      [[ $1 != *.* ]] || for kind in ${1//|/ }; do compgen -f -X "!*.${kind##*.}" -- "$word"; done)
  fi
}

_tactel() {
  local word=${COMP_WORDS[COMP_CWORD]} previous positional i
  local -a before=("${COMP_WORDS[@]:0:COMP_CWORD}")
  if [[ $word == [=:] ]]; then before+=("$word") word=; fi  # --rung=NAME and replay:FILE are three words of bash
  if [[ ${before[-1]} == = ]]; then unset 'before[-1]'; fi
  previous=${before[-1]}
  local -a commands options command=("${COMP_WORDS[0]/#\~/$HOME}")
  local -A types
  COMPREPLY=()
  if [[ $previous == : ]]; then
    case ${before[-2]} in
      simulate) _tactel_value SCENE.toml ;;
      replay | csv) _tactel_value FILE ;;
    esac
    return
  fi
  _tactel_read_help "${command[@]}"
  for ((i = 1; i < COMP_CWORD; ++i)); do
    if ((i == 1)) && [[ ${COMP_WORDS[i]} == help ]]; then continue; fi
    [[ " ${commands[*]} " == *" ${COMP_WORDS[i]} "* ]] || break
    command+=("${COMP_WORDS[i]}")
    _tactel_read_help "${command[@]}"
  done
  if [[ -n $previous && -n ${types[$previous]-} ]]; then
    _tactel_value "${types[$previous]}"
  elif [[ $word == -* || ( ${#commands[@]} -eq 0 && -z $positional ) ]]; then
    mapfile -t COMPREPLY < <(compgen -W "${options[*]}" -- "$word")
  elif ((${#commands[@]})); then
    mapfile -t COMPREPLY < <(compgen -W "${commands[*]} $([[ ${#command[@]} -gt 1 || $previous == help ]] || echo help --help --version)" -- "$word")
  else
    _tactel_value "$positional"
  fi
}
complete -F _tactel tactel
