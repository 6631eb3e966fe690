"""Questions of users, each answered by computed tables: one file per study, with its prose in text/NAME.md.

`python -m studies all` computes what is missing and writes the page docs/studies.md. Studies use the package through its public
face only: `frictionbench` and the names that its folders export.
"""
