"""Names, units and order of every signal; quantities with units; YAML files that know their lines."""
