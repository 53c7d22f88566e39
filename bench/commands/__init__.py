"""The subcommands of ``bench``, one file each: they parse options; what they call is imported when it is used."""
