"""Evidence: from residuals and sensitivities to named causes, groups of look-alikes and the next manoeuvre."""
